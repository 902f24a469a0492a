// Stable compaction: count, scan, scatter (Blelloch 1990), without atomics.
//
// `count` adds up, for every chunk of CHUNK rays, each stream of the packed counts; `offsets` turns these few sums
// into places and tells the host the totals; `scan` then gives every ray its first place in each stream. Order in a queue is the order of the
// parents, on every device and for every work-group size. One work-item a chunk, so the loop is sequential: that
// is three times as fast on a CPU as atomics, and deterministic.

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

// sums[stream][chunk]
__kernel void count(__global const uint *spawn, uint n, uint ambient_samples, uint chunks, __global uint *sums)
{
    const uint chunk = get_global_id(0);
    if (chunk >= chunks) return;
    uint total[STREAMS];
    for (uint s = 0; s < STREAMS; s++) total[s] = 0;
    const uint end = min((chunk + 1) * CHUNK, n);
    for (uint i = chunk * CHUNK; i < end; i++)
        for (uint s = 0; s < STREAMS; s++) total[s] += stream_count(spawn[i], s, ambient_samples);
    for (uint s = 0; s < STREAMS; s++) sums[s * chunks + chunk] = total[s];
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
// sorted by pixel, so the count is a binary search.
__kernel void rank(__global const uint *pixel_of, uint n, __global const uint *other_pixel_of,
                   __global const uint *other_first, uint other_n, uint other_total, uint other_goes_first,
                   __global uint *slot)
{
    const uint i = get_global_id(0);
    if (i >= n) return;
    const uint pixel = pixel_of[i];
    uint low = 0, high = other_n;
    while (low < high) {
        const uint middle = (low + high) / 2;
        const bool before = other_goes_first ? other_pixel_of[middle] <= pixel : other_pixel_of[middle] < pixel;
        if (before) low = middle + 1;
        else high = middle;
    }
    slot[i] += low < other_n ? other_first[low] : other_total;
}
