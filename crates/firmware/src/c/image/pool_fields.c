    const span *rows;     /* the same of rows of an image: of every row of outputs */
    uint32_t row_count, lines, line;    /* their number; rows of a window, and their distance */
    uint32_t from_row, to_row, tables;  /* the same in bytes, of inputs and outputs; factors of a row of outputs */
