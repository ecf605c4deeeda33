    uint32_t i, at = 0;
    for (i = 0; i < TAXEL_@NAME@_ATTRIBUTES; i++) {
        const uint32_t count = taxel_@name@_attribute_classes[i];
        @function@(row + at, count);
@temper@        at += count;
    }
