const char *const taxel_@name@_attribute_names[TAXEL_@NAME@_ATTRIBUTES] = {
@names@};

const uint16_t taxel_@name@_attribute_classes[TAXEL_@NAME@_ATTRIBUTES] = {@sizes@};

