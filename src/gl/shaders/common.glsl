// SPDX-License-Identifier: Apache-2.0
// Shared by all shaders; prepended to each of them.
//
// Pixels of a target: column x from the left, row y from the image's top,
// which is GL's bottom, as nothing is flipped. Corner (x, y) is the pixel's
// corner nearest to (0, 0).

// Clip coordinates of a pixel corner. Exact at 0 and at `size`, and well
// within the rasterizer's 1/256 pixel between: edges lie on pixel edges.
vec4 clip_of_corner(ivec2 corner, ivec2 size)
{
    return vec4(vec2(2 * corner - size) / vec2(size), 0.0, 1.0);
}

// Corner of a quad, each coordinate 0 or 1, of vertex 0..5 of its triangles.
ivec2 quad_corner(int vertex)
{
    const int x[6] = int[6](0, 1, 0, 0, 1, 1);
    const int y[6] = int[6](0, 0, 1, 1, 0, 1);
    return ivec2(x[vertex], y[vertex]);
}
