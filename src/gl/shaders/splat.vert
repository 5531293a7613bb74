// SPDX-License-Identifier: Apache-2.0
// Glare sensors: one degenerate polygon for each cell of a grid (Ando et al.
// 2007, section 3.1), a pixel or a group. A bright sensor opens its polygon to
// the kernel's size, shrunk to where the kernel counts (section 4.3); a dark
// one leaves all corners in one point.
//
// in   sensors   texel = one cell: sum of its rgb light (scene-linear), a its
//                luminance L0
//      places    as group.frag writes them; any texture when grid.y is -1
//      reaches   by gp_source_bin(L0): pixels from P0 to the polygon's edge
//      grid      x: pixels of a cell's side; y: the blur whose cells open, -1
//                when cells are pixels
//      cells     columns and rows of cells in use
//      range     first cell and the one after the last, in row order
//      offset    target pixel at the corner of cell (0, 0)
//      extent    columns and rows of the kernel
//      centre    of the kernel, its whole part, in kernel pixels
//      rest      the rest of the centre: 0 or 1/2 each
//      shrinks   x: 1 when polygons shrink
//      size      columns and rows of the target
// out  quads cut to the target, so that none leaves the clip volume
// CPU twin: plain_groups.h of the tests; direct.c where cells are pixels
uniform sampler2D sensors;
uniform sampler2D places;
layout(std140) uniform reaches
{
    vec4 reach[128];
};
uniform ivec2 grid;
uniform ivec2 cells;
uniform ivec2 range;
uniform ivec2 offset;
uniform ivec2 extent;
uniform ivec2 centre;
uniform vec2 rest;
uniform ivec2 shrinks;
uniform ivec2 size;

flat out vec3 light;    // of the polygon
flat out ivec2 corner;  // target pixel of kernel pixel (0, 0)
flat out vec2 fraction; // in [0, 1): of the kernel, right and below `corner`

const int QUADS = 64; // of one instance; the same as in splat/draw.c

void main()
{
    int sensor = range.x + gl_InstanceID * QUADS + gl_VertexID / 6;
    ivec2 at = ivec2(sensor % cells.x, sensor / cells.x);
    vec4 found = vec4(0.0);
    if (sensor < range.y)
        found = texelFetch(sensors, at, 0);
    bool open = any(greaterThan(found, vec4(0.0)));
    vec2 p0 = vec2(0.0);
    if (open && grid.y >= 0) {
        vec4 place = texelFetch(places, at, 0);
        open = int(place.z) == grid.y;
        p0 = place.xy;
    }

    ivec2 base = at * grid.x + offset;
    vec2 whole = floor(p0 - rest);
    light = found.rgb;
    fraction = p0 - rest - whole;
    corner = base + ivec2(whole) - centre;
    ivec2 low = corner;
    ivec2 high = corner + extent + ivec2(greaterThan(fraction, vec2(0.0)));
    if (open && shrinks.x > 0) {
        int bin = floatBitsToInt(found.a) >> 22 & 511;
        int far = int(reach[bin >> 2][bin & 3]);
        low = max(low, base + ivec2(ceil(p0)) - far);
        high = min(high, base + ivec2(floor(p0)) + far + 1);
    }
    open = open && all(greaterThan(high, low));

    low = clamp(low, ivec2(0), size);
    high = clamp(high, ivec2(0), size);
    if (!open)
        high = low;
    gl_Position = clip_of_corner(
        low + (high - low) * quad_corner(gl_VertexID % 6), size);
}
