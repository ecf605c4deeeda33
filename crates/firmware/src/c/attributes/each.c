    uint32_t i;
    for (i = 0; i < TAXEL_@NAME@_ATTRIBUTES; i++) {
        const uint32_t count = taxel_@name@_attribute_classes[i];
        @function@(row, count);
@temper@        row += count;
    }
