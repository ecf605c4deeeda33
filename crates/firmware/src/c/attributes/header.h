/* Attributes, and the classes of each one; TAXEL_@NAME@_CLASSES counts those of all. */
#define TAXEL_@NAME@_ATTRIBUTES @attributes@u
@sizes@
/* Names of the attributes, and how many classes each has: its names and probabilities stand behind those of the ones before it. */
extern const char *const taxel_@name@_attribute_names[TAXEL_@NAME@_ATTRIBUTES];
extern const uint16_t taxel_@name@_attribute_classes[TAXEL_@NAME@_ATTRIBUTES];

