// The tree over the finite primitives: binned surface-area heuristic (Wald 2007, "On fast construction of
// SAH-based bounding volume hierarchies"), binary first, then collapsed to wide nodes (collapse.clh) whose leaves are
// blocks of up to eight primitives of one kind.
//
// The picture does not depend on the tree, only the time does. Two phases make the binary tree: `split_top` splits
// the whole set until there are enough ranges to share out, `build_subtree` finishes each range on a core of its
// own, and weighs how it collapses. The larger half of a split goes on the stack first, so a stack stays below log2(n)
// entries; below DEEP levels sets are halved, so that no distribution makes the tree deeper than the traversal's stack
// allows.
#include "collapse.clh"

#define BINS 16
#define ALONE_COSTS (2 * BLOCK)  // lanes of a block that a primitive takes which is neither triangle nor sphere
#define DEEP 20

inline float4 lower4(float4 a, float4 b) { return select(b, a, a < b); }
inline float4 upper4(float4 a, float4 b) { return select(b, a, a > b); }

// what testing a set of primitives costs, in lanes of blocks, and in blocks
inline int lanes_for(uchar kind) { return kind == BLOCK_OTHER ? ALONE_COSTS : 1; }
inline float blocks_of(int lanes) { return (float)((lanes + BLOCK - 1) / BLOCK); }

typedef struct {
    int axis, bin;  // items whose bin on `axis` is below `bin` go left; axis < 0: no split found
    float cost;
} Split;

// The cheapest of the BINS - 1 planes on each axis. A middle is taken as low + high: twice the middle will do.
inline Split best_split(__global const Box *boxes, __global const uchar *kinds, __global const int *item, int start,
                        int end, float4 middle_low, float4 scale)
{
    float4 low[3][BINS], high[3][BINS];
    int lanes[3][BINS];
    for (int axis = 0; axis < 3; axis++)
        for (int k = 0; k < BINS; k++) {
            low[axis][k] = (float4)(INFINITY);
            high[axis][k] = (float4)(-INFINITY);
            lanes[axis][k] = 0;
        }
    for (int i = start; i < end; i++) {
        const float4 a = boxes[item[i]].low, b = boxes[item[i]].high;
        const int4 bin = clamp(convert_int4_sat((a + b - middle_low) * scale), (int4)(0), (int4)(BINS - 1));
        const int more = lanes_for(kinds[item[i]]);
        low[0][bin.x] = lower4(a, low[0][bin.x]); high[0][bin.x] = upper4(b, high[0][bin.x]); lanes[0][bin.x] += more;
        low[1][bin.y] = lower4(a, low[1][bin.y]); high[1][bin.y] = upper4(b, high[1][bin.y]); lanes[1][bin.y] += more;
        low[2][bin.z] = lower4(a, low[2][bin.z]); high[2][bin.z] = upper4(b, high[2][bin.z]); lanes[2][bin.z] += more;
    }
    Split best = {-1, 0, INFINITY};
    for (int axis = 0; axis < 3; axis++) {
        float right_area[BINS];
        int right_lanes[BINS];
        float4 side_low = (float4)(INFINITY), side_high = (float4)(-INFINITY);
        int side_lanes = 0;
        for (int k = BINS - 1; k > 0; k--) {
            side_low = lower4(low[axis][k], side_low);
            side_high = upper4(high[axis][k], side_high);
            side_lanes += lanes[axis][k];
            right_area[k] = half_area(side_low, side_high);
            right_lanes[k] = side_lanes;
        }
        side_low = (float4)(INFINITY);
        side_high = (float4)(-INFINITY);
        side_lanes = 0;
        for (int k = 1; k < BINS; k++) {
            side_low = lower4(low[axis][k - 1], side_low);
            side_high = upper4(high[axis][k - 1], side_high);
            side_lanes += lanes[axis][k - 1];
            if (side_lanes == 0 || right_lanes[k] == 0) continue;
            const float cost = half_area(side_low, side_high) * blocks_of(side_lanes)
                             + right_area[k] * blocks_of(right_lanes[k]);
            if (cost < best.cost) {
                best.axis = axis;
                best.bin = k;
                best.cost = cost;
            }
        }
    }
    return best;
}

// Makes nodes[node] of the items start .. end: a leaf, or a split whose place is returned (0 for a leaf).
inline int split_node(__global const Box *boxes, __global const uchar *kinds, __global int *item,
                      __global BuildNode *node, int start, int end, int depth)
{
    float4 low = (float4)(INFINITY), high = (float4)(-INFINITY), middle_low = low, middle_high = high;
    int lanes = 0;
    for (int i = start; i < end; i++) {
        const float4 a = boxes[item[i]].low, b = boxes[item[i]].high, middle = a + b;
        low = lower4(a, low);
        high = upper4(b, high);
        middle_low = lower4(middle, middle_low);
        middle_high = upper4(middle, middle_high);
        lanes += lanes_for(kinds[item[i]]);
    }
    node->low = low;
    node->high = high;
    node->first = start;
    node->count = end - start;
    node->kind = kinds[item[start]];
    node->part = node->pad0 = node->pad1 = 0;
    node->shares[0] = node->shares[1] = 0;
    const int count = end - start;
    Split split = {-1, 0, INFINITY};
    const float4 extent = middle_high - middle_low;
    // an axis without extent has all its items in bin 0, and no plane there is a split
    const float4 scale = select((float4)(0.0f), (BINS * 0.9999f) / extent, extent > 1e-30f);
    if (count > 1 && depth < DEEP) split = best_split(boxes, kinds, item, start, end, middle_low, scale);
    const float area = half_area(low, high);
    if (count <= BLOCK && !(split.axis >= 0 && split.cost + area < area * blocks_of(lanes))) {
        // a leaf; if its kinds are mixed, the first kind parts from the others
        int place = start;
        for (int i = start; i < end; i++)
            if (kinds[item[i]] == node->kind) {
                const int swap = item[i];
                item[i] = item[place];
                item[place++] = swap;
            }
        return place < end ? place : 0;
    }
    if (split.axis < 0) return start + count / 2;
    const float from = split.axis == 0 ? middle_low.x : split.axis == 1 ? middle_low.y : middle_low.z;
    const float per_bin = split.axis == 0 ? scale.x : split.axis == 1 ? scale.y : scale.z;
    int i = start, j = end - 1;
    while (i <= j) {
        const int moved = item[i];
        __global const float *a = (__global const float *)&boxes[moved].low;
        if (clamp(convert_int_sat((a[split.axis] + a[4 + split.axis] - from) * per_bin), 0, BINS - 1) < split.bin) {
            i++;
        } else {
            item[i] = item[j];
            item[j--] = moved;
        }
    }
    return i;
}

typedef struct {
    int node, start, end, depth;
} Task;

inline void push_halves(Task *stack, int *size, const Task parent, int middle, int children)
{
    const Task left = {children, parent.start, middle, parent.depth + 1};
    const Task right = {children + 1, middle, parent.end, parent.depth + 1};
    const bool left_larger = middle - parent.start > parent.end - middle;
    stack[(*size)++] = left_larger ? left : right;
    stack[(*size)++] = left_larger ? right : left;
}

// Splits the largest waiting range until there are `wanted`, or none above `least`. tasks[k] = node, start, end,
// depth; a subtree of m items gets the nodes tasks[k].node and 2 m - 2 others from `used` on.
__kernel void split_top(__global const Box *boxes, __global const uchar *kinds, int n, int wanted, int least,
                        __global int *item, __global BuildNode *nodes, __global int4 *tasks, __global int *counts)
{
    Task waiting[64];
    int size = 1, used = 1;
    const Task all = {0, 0, n, 0};
    waiting[0] = all;
    while (size < wanted) {
        int largest = 0;
        for (int k = 1; k < size; k++)
            if (waiting[k].end - waiting[k].start > waiting[largest].end - waiting[largest].start) largest = k;
        const Task task = waiting[largest];
        if (task.end - task.start <= least) break;
        const int middle = split_node(boxes, kinds, item, nodes + task.node, task.start, task.end, task.depth);
        nodes[task.node].first = used;
        nodes[task.node].count = 0;
        waiting[largest] = waiting[--size];
        push_halves(waiting, &size, task, middle, used);
        used += 2;
    }
    for (int k = 0; k < size; k++)
        tasks[k] = (int4)(waiting[k].node, waiting[k].start, waiting[k].end, waiting[k].depth);
    counts[0] = size;
    counts[1] = used;
}

// Finishes subtree k of split_top in nodes of its own: 2 * start + used is free for it, since the m items before
// it need at most 2 m nodes. ways[k]: how it may collapse; nothing where there is no such subtree.
__kernel void build_subtree(__global const Box *boxes, __global const uchar *kinds, __global const int4 *tasks,
                            __global const int *counts, __global int *item, __global BuildNode *nodes,
                            __global Ways *ways)
{
    const int k = get_global_id(0);
    ways[k].inner = 0;
    if (k >= counts[0]) return;
    Task stack[STACK];
    int size = 1, used = counts[1] + 2 * tasks[k].y;
    const Task whole = {tasks[k].x, tasks[k].y, tasks[k].z, tasks[k].w};
    stack[0] = whole;
    while (size > 0) {
        const Task task = stack[--size];
        const int middle = split_node(boxes, kinds, item, nodes + task.node, task.start, task.end, task.depth);
        if (middle == 0) continue;
        nodes[task.node].first = used;
        nodes[task.node].count = 0;
        push_halves(stack, &size, task, middle, used);
        used += 2;
    }
    ways[k] = weigh(nodes, whole.node, 0);
    nodes[whole.node].part = k + 1;
}

// Wide nodes from binary ones, whose subtrees are weighed.
// leaves[kind][block] = first item, count; counts = nodes, triangle blocks, sphere blocks, other blocks. The first
// block of the other kinds is empty: the unused lanes of a node lead there, since the box test of a ray from very
// far away may overflow and accept them.
__kernel void collapse(__global BuildNode *binary, __global const Ways *ways, __global WideNode *nodes, int most_blocks,
                       __global int2 *leaves, __global int *counts)
{
    int2 stack[STACK];  // binary node, wide node
    int size = 1, used = 1, blocks[3] = {0, 0, 0};
    leaves[BLOCK_OTHER * most_blocks + blocks[BLOCK_OTHER]++] = (int2)(0, 0);
    stack[0] = (int2)(0, 0);
    weigh(binary, 0, ways);
    while (size > 0) {
        const int2 top = stack[--size];
        int child[WIDE];
        const int children = children_of(binary, top.x, child);
        __global WideNode *node = nodes + top.y;
        for (int k = 0; k < WIDE; k++) {
            float4 low = (float4)(INFINITY), high = (float4)(-INFINITY);
            int reference = ~BLOCK_OTHER;
            if (k < children) {
                __global const BuildNode *from = binary + child[k];
                low = from->low;
                high = from->high;
                if (from->count == 0) {
                    reference = used++;
                    stack[size++] = (int2)(child[k], reference);
                } else {
                    const int block = blocks[from->kind]++;
                    leaves[from->kind * most_blocks + block] = (int2)(from->first, from->count);
                    reference = ~(block * 4 + from->kind);
                }
            }
            node->planes[k] = low.x;
            node->planes[WIDE + k] = high.x;
            node->planes[2 * WIDE + k] = low.y;
            node->planes[3 * WIDE + k] = high.y;
            node->planes[4 * WIDE + k] = low.z;
            node->planes[5 * WIDE + k] = high.z;
            node->child[k] = reference;
        }
    }
    counts[0] = used;
    for (int kind = 0; kind < 3; kind++) counts[1 + kind] = blocks[kind];
}

// The lanes of a block whose numbers are known, from what the scene holds now; unused lanes are NaN.
inline void fill_triangles(__global TriangleBlock *block, __global const int *number,
                           __global const Primitive *primitives, __global const Triangle *triangles)
{
    for (int k = 0; k < BLOCK; k++) {
        Triangle t;
        if (number[k] >= 0) t = triangles[primitives[number[k]].index];
        else t.v0 = t.v1 = t.v2 = (float4)(NO_HIT);
        block->primitive[k] = number[k];
        block->corners[k] = t.v0.x; block->corners[8 + k] = t.v0.y; block->corners[16 + k] = t.v0.z;
        block->corners[24 + k] = t.v1.x; block->corners[32 + k] = t.v1.y; block->corners[40 + k] = t.v1.z;
        block->corners[48 + k] = t.v2.x; block->corners[56 + k] = t.v2.y; block->corners[64 + k] = t.v2.z;
    }
}

inline void fill_spheres(__global SphereBlock *block, __global const int *number,
                         __global const Primitive *primitives, __global const Sphere *spheres)
{
    for (int k = 0; k < BLOCK; k++) {
        const float4 s = number[k] < 0 ? (float4)(NO_HIT) : spheres[primitives[number[k]].index].center_radius;
        block->primitive[k] = number[k];
        block->places[k] = s.x; block->places[8 + k] = s.y; block->places[16 + k] = s.z; block->places[24 + k] = s.w;
    }
}

inline void numbers_of(__global int *number, int2 leaf, __global const int *item, __global const int *finite)
{
    for (int k = 0; k < BLOCK; k++) number[k] = k < leaf.y ? finite[item[leaf.x + k]] : -1;
}

__kernel void pack_triangles(__global const int2 *leaves, int blocks, __global const int *item,
                             __global const int *finite, __global const Primitive *primitives,
                             __global const Triangle *triangles, __global TriangleBlock *out)
{
    const int b = get_global_id(0);
    if (b >= blocks) return;
    numbers_of(out[b].primitive, leaves[b], item, finite);
    fill_triangles(out + b, out[b].primitive, primitives, triangles);
}

__kernel void pack_spheres(__global const int2 *leaves, int blocks, __global const int *item,
                           __global const int *finite, __global const Primitive *primitives,
                           __global const Sphere *spheres, __global SphereBlock *out)
{
    const int b = get_global_id(0);
    if (b >= blocks) return;
    numbers_of(out[b].primitive, leaves[b], item, finite);
    fill_spheres(out + b, out[b].primitive, primitives, spheres);
}

__kernel void pack_others(__global const int2 *leaves, int blocks, __global const int *item,
                          __global const int *finite, __global int *order)
{
    const int b = get_global_id(0);
    if (b < blocks) numbers_of(order + 8 * (size_t)b, leaves[b], item, finite);
}

// The same leaves of primitives that moved.
__kernel void refill_triangles(int blocks, __global const TriangleBlock *before, __global const Primitive *primitives,
                               __global const Triangle *triangles, __global TriangleBlock *out)
{
    const int b = get_global_id(0);
    if (b < blocks) fill_triangles(out + b, before[b].primitive, primitives, triangles);
}

__kernel void refill_spheres(int blocks, __global const SphereBlock *before, __global const Primitive *primitives,
                             __global const Sphere *spheres, __global SphereBlock *out)
{
    const int b = get_global_id(0);
    if (b < blocks) fill_spheres(out + b, before[b].primitive, primitives, spheres);
}
