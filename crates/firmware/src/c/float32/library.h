/* The network is in 32-bit floats: a processor needs an FPU with fused products. */
#define TAXEL_@NAME@_NEEDS_FPU 1u
