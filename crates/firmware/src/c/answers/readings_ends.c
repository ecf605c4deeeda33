        least = i == 0u || own.spread < least ? own.spread : least;
        most = i == 0u || own.spread > most ? own.spread : most;
        bottom = i == 0u || own.mean < bottom ? own.mean : bottom;
        top = i == 0u || own.mean > top ? own.mean : top;
