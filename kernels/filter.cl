// The film of a picture with a filter: pixels from samples, each of which has a place of its own there until now.
#include "filter.clh"

// What each sample of the pixels counts for in its pixel: n of them, those of a pixel next to each other.
__kernel void weigh_samples(__global const Camera *cameras, __global const uint *pixels, uint n, __global float *weights)
{
    const uint first = get_global_id(0) * PACKET;
    if (first >= n) return;
    const Camera camera = cameras[0];
    const uint samples = camera.grid * camera.grid;
    ALIGNED uint number[PACKET];
    for (uint k = 0; k < PACKET; k++) number[k] = pixels[min(first + k, n - 1) / samples];
    const uintP i = counting_from(first), sample = i - divided(i, samples) * samples;
    const uintP key = combine(combine((uintP)(camera.seed), *(uintP *)number), sample);
    floatP x, y;
    in_grid(camera, key, sample, &x, &y);
    const floatP weight = filter_weight(camera, off_middle(camera, x)) * filter_weight(camera, off_middle(camera, y));
    ALIGNED float lane[PACKET];
    *(floatP *)lane = weight;
    for (uint k = 0; k < PACKET && first + k < n; k++) weights[first + k] = lane[k];
}

// Weighed means of what the samples bring, n values: BANDS of each pixel of each plane. Light that overflowed counts as
// the brightest that a pixel holds, as where there is no filter. Jitter may put few samples where the filter is
// positive: where three quarters of the weights or more cancel, or all are 0, all samples count alike.
__kernel void weighted_means(uint n, __global const float *film, __global const float *weights, uint pixels,
                             uint samples, __global float *means)
{
    const uint i = get_global_id(0);
    if (i >= n) return;
    const uint band = i % BANDS, pixel = i / BANDS % pixels;
    __global const float *weight = weights + (size_t)pixel * samples;
    __global const float *light = film + (size_t)(i / BANDS) * samples * BANDS + band;
    float sum = 0.0f, whole = 0.0f, sizes = 0.0f, all = 0.0f;
    for (uint s = 0; s < samples; s++) {
        const float one = light[(size_t)s * BANDS] <= BRIGHTEST ? light[(size_t)s * BANDS] : BRIGHTEST;
        sum += weight[s] * one;
        whole += weight[s];
        sizes += fabs(weight[s]);
        all += one;
    }
    const float mean = whole > 0.25f * sizes ? sum / whole : all / (float)samples;
    means[i] = mean <= BRIGHTEST ? mean : BRIGHTEST;
}
