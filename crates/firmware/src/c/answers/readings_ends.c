        low_spread = i == 0u || own.spread < low_spread ? own.spread : low_spread;
        high_spread = i == 0u || own.spread > high_spread ? own.spread : high_spread;
        low_mean = i == 0u || own.mean < low_mean ? own.mean : low_mean;
        high_mean = i == 0u || own.mean > high_mean ? own.mean : high_mean;
