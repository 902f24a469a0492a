// The tree over primitives that moved: its nodes and leaves as they are, with the boxes of now. Boxes only ever grow
// together, so these are those that a leaf's primitives, and all that lies below a node, ask for (Kopta et al. 2012,
// "Fast, Effective BVH Updates for Animated Scenes", section 3). A tree that no longer fits is slow, never wrong; what
// `box_areas` adds up tells when to build it anew.
#include "collapse.clh"

inline void put_box(__global WideNode *node, int k, float4 low, float4 high)
{
    node->planes[k] = low.x;
    node->planes[WIDE + k] = high.x;
    node->planes[2 * WIDE + k] = low.y;
    node->planes[3 * WIDE + k] = high.y;
    node->planes[4 * WIDE + k] = low.z;
    node->planes[5 * WIDE + k] = high.z;
}

inline float4 low_of(__global const WideNode *node, int k)
{
    return (float4)(node->planes[k], node->planes[2 * WIDE + k], node->planes[4 * WIDE + k], 0.0f);
}

inline float4 high_of(__global const WideNode *node, int k)
{
    return (float4)(node->planes[WIDE + k], node->planes[3 * WIDE + k], node->planes[5 * WIDE + k], 0.0f);
}

// A copy of each node with the boxes of its leaves; `boxes` are by the number of the primitive.
__kernel void refit_leaves(int nodes, __global const Box *boxes, __global const TriangleBlock *triangle_blocks,
                           __global const SphereBlock *sphere_blocks, __global const int *order,
                           __global const WideNode *before, __global WideNode *out)
{
    const int n = get_global_id(0);
    if (n >= nodes) return;
    for (int k = 0; k < WIDE; k++) {
        const int reference = before[n].child[k];
        out[n].child[k] = reference;
        if (reference >= 0) continue;
        const int block = ~reference / 4, kind = ~reference & 3;
        __global const int *number = kind == BLOCK_TRIANGLE ? triangle_blocks[block].primitive
                                   : kind == BLOCK_SPHERE   ? sphere_blocks[block].primitive
                                                            : order + 8 * (size_t)block;
        float4 low = (float4)(INFINITY), high = (float4)(-INFINITY);
        for (int i = 0; i < BLOCK; i++) {
            if (number[i] < 0) continue;
            low = fmin(low, boxes[number[i]].low);
            high = fmax(high, boxes[number[i]].high);
        }
        put_box(out + n, k, low, high);
    }
}

// The boxes of nodes within the nodes of one level, when all levels below are done.
__kernel void refit_level(__global const uint *numbers, int first, int count, __global WideNode *nodes)
{
    const int i = get_global_id(0);
    if (i >= count) return;
    __global WideNode *node = nodes + numbers[first + i];
    for (int k = 0; k < WIDE; k++) {
        if (node->child[k] < 0) continue;
        __global const WideNode *below = nodes + node->child[k];
        float4 low = (float4)(INFINITY), high = (float4)(-INFINITY);
        for (int j = 0; j < WIDE; j++) {
            low = fmin(low, low_of(below, j));
            high = fmax(high, high_of(below, j));
        }
        put_box(node, k, low, high);
    }
}

// areas[2 n], [2 n + 1]: that of all boxes of node n together, and that of a box about them.
__kernel void box_areas(int nodes, __global const WideNode *tree, __global float *areas)
{
    const int n = get_global_id(0);
    if (n >= nodes) return;
    float sum = 0.0f;
    float4 low = (float4)(INFINITY), high = (float4)(-INFINITY);
    for (int k = 0; k < WIDE; k++) {
        const float4 a = low_of(tree + n, k), b = high_of(tree + n, k);
        sum += half_area(a, b);
        low = fmin(low, a);
        high = fmax(high, b);
    }
    areas[2 * n] = sum;
    areas[2 * n + 1] = half_area(low, high);
}
