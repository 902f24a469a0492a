// What the device can do at best: move memory, and compute.
//
// `copy` moves `count` runs of 8 floats a work-item, `times` over: once through memory, or often within a cache.
// `arithmetic` keeps eight independent chains of fused multiply-adds on WIDTH floats in registers: enough to hide
// the latency of two units. The values stay finite (the factor is below 1) and reach memory, so nothing is left out.
#if WIDTH == 16
typedef float16 floats;
#else
typedef float8 floats;
#endif

__kernel void copy(__global const float8 *from, __global float8 *to, int count, int times)
{
    const size_t first = get_global_id(0) * count;
    for (int turn = 0; turn < times; turn++)
        for (int i = 0; i < count; i++) to[first + i] = from[first + i];
}

__kernel void arithmetic(__global float *out, float factor, float addend, int steps)
{
    const floats a = factor, b = addend;
    floats c0 = get_global_id(0), c1 = c0 + 1.0f, c2 = c0 + 2.0f, c3 = c0 + 3.0f;
    floats c4 = c0 + 4.0f, c5 = c0 + 5.0f, c6 = c0 + 6.0f, c7 = c0 + 7.0f;
    for (int i = 0; i < steps; i++) {
        c0 = fma(c0, a, b); c1 = fma(c1, a, b); c2 = fma(c2, a, b); c3 = fma(c3, a, b);
        c4 = fma(c4, a, b); c5 = fma(c5, a, b); c6 = fma(c6, a, b); c7 = fma(c7, a, b);
    }
    const floats sum = ((c0 + c1) + (c2 + c3)) + ((c4 + c5) + (c6 + c7));
    out[get_global_id(0)] = sum.s0 + sum.s1 + sum.s2 + sum.s3 + sum.s4 + sum.s5 + sum.s6 + sum.s7;
}
