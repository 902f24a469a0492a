// Stable compaction: count, scan, scatter (Blelloch 1990), without atomics.
//
// `count` adds up, for every chunk of CHUNK rays, each stream of the packed counts; `offsets` turns these few sums
// into places and tells the host the totals; `scan` then gives every ray its first place in each stream. Order in
// a queue is the order of the parents, on every device and for every work-group size. One work-item a chunk, so
// the loop is sequential: that is three times as fast on a CPU as atomics, and deterministic.
#include "lanes.clh"

inline uint stream_count(uint spawn, uint stream, uint ambient_samples)
{
    switch (stream) {
    case STREAM_FEELERS: return spawn & SPAWN_FEELERS;
    case STREAM_REFLECTION: return (spawn & SPAWN_REFLECTION) != 0;
    case STREAM_TRANSMISSION: return (spawn & SPAWN_TRANSMISSION) != 0;
    case STREAM_AMBIENT: return spawn & SPAWN_AMBIENT ? ambient_samples : 0;
    case STREAM_HIT: return (spawn & SPAWN_HIT) != 0;
    case STREAM_GROUPS: return (spawn & SPAWN_GROUPS) / SPAWN_GROUP;
    default: return (spawn & SPAWN_TOTAL_INTERNAL) != 0;
    }
}

// sums[stream][chunk]. Packets of words are added up lane by lane, the lanes at the end.
__kernel void count(__global const uint *spawn, uint n, uint ambient_samples, uint chunks, __global uint *sums)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunks) return;
    uintP total[STREAMS];
    for (uint s = 0; s < STREAMS; s++) total[s] = (uintP)(0);
    const uint end = min((chunk + 1) * CHUNK, n);
    for (uint first = chunk * CHUNK; first < end; first += PACKET) {
        const intP there = counting_from(first) < (uintP)(end);
        const uintP words = as_uintP(load_word(spawn, first, n) & there);
        total[STREAM_FEELERS] += words & SPAWN_FEELERS;
        total[STREAM_REFLECTION] -= as_uintP((words & SPAWN_REFLECTION) != 0u);
        total[STREAM_TRANSMISSION] -= as_uintP((words & SPAWN_TRANSMISSION) != 0u);
        total[STREAM_AMBIENT] -= as_uintP((words & SPAWN_AMBIENT) != 0u);
        total[STREAM_HIT] -= as_uintP((words & SPAWN_HIT) != 0u);
        total[STREAM_TOTAL_INTERNAL] -= as_uintP((words & SPAWN_TOTAL_INTERNAL) != 0u);
#if GROUP
        total[STREAM_GROUPS] += (words & SPAWN_GROUPS) / SPAWN_GROUP;
#endif
    }
    total[STREAM_AMBIENT] *= ambient_samples;
    for (uint s = 0; s < STREAMS; s++) {
        uint lane[PACKET], sum = 0;
        *(uintP *)lane = total[s];
        for (uint k = 0; k < PACKET; k++) sum += lane[k];
        sums[s * chunks + chunk] = sum;
    }
}

// sums[stream][chunk] become each chunk's first place in each stream. One work-item: there are few chunks. (Totals
// are wider than places, so that the host sees a queue that is too large.)
__kernel void offsets(uint chunks, __global uint *sums, __global ulong *totals)
{
    if (get_global_id(0) > 0) return;
    for (uint s = 0; s < STREAMS; s++) {
        ulong total = 0;
        for (uint chunk = 0; chunk < chunks; chunk++) {
            const uint sum = sums[s * chunks + chunk];
            sums[s * chunks + chunk] = total;
            total += sum;
        }
        totals[s] = total;
    }
}

// offsets[stream][chunk] in, first[stream][ray] out, for one stream
__kernel void scan(__global const uint *spawn, uint n, uint ambient_samples, uint chunks,
                   __global const uint *offsets, uint stream, __global uint *first)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunks) return;
    uint place = offsets[stream * chunks + chunk];
    const uint end = min((chunk + 1) * CHUNK, n);
    for (uint i = chunk * CHUNK; i < end; i++) {
        first[i] = place;
        place += stream_count(spawn[i], stream, ambient_samples);
    }
}

// Children of two parent queues are merged by pixel, so that each pixel's rays stand together. A ray's place among
// its own queue's children is known from `scan`; this adds the number of children that rays of the other queue
// put before it: those of smaller pixels, and of the same pixel where the other queue goes first. Both queues are
// sorted by pixel: where a chunk begins is found by binary search, from there both are followed side by side.
inline bool comes_before(uint other_pixel, uint pixel, uint other_goes_first)
{
    return other_goes_first ? other_pixel <= pixel : other_pixel < pixel;
}

__kernel void rank(__global const uint *pixel_of, uint n, __global const uint *other_pixel_of,
                   __global const uint *other_first, uint other_n, uint other_total, uint other_goes_first,
                   __global uint *slot)
{
    const uint begin = get_global_id(0) * CHUNK;
    if (begin >= n) return;
    uint other = 0;
    for (uint high = other_n; other < high;) {
        const uint middle = (other + high) / 2;
        if (comes_before(other_pixel_of[middle], pixel_of[begin], other_goes_first)) other = middle + 1;
        else high = middle;
    }
    const uint end = min(begin + CHUNK, n);
    for (uint i = begin; i < end; i++) {
        while (other < other_n && comes_before(other_pixel_of[other], pixel_of[i], other_goes_first)) other++;
        slot[i] += other < other_n ? other_first[other] : other_total;
    }
}
