// SPDX-License-Identifier: Apache-2.0
// Groups and clusters (Ando et al. 2007, sections 4.1 and 4.2): each fragment
// is a cell, a block of side x side pixels, that becomes one polygon.
//
// in   sources  texel = one pixel: rgb light after the bright pass
//               (scene-linear), a its luminance
//      parents  clusters made by this same pass; any texture when none are
//      origin   pixel of `sources` at the corner of cell (0, 0); may be < 0
//      size     columns and rows of `sources` in use
//      side     x: pixels of a cell's side; y: cells of a parent's side, 0
//               without parents
//      boxes    x: bits of the indices of gp_blur_box that may be taken
//      fill     share of bright pixels under which the cell stays shut
// out  light    sum of rgb, and formula (1): L0, the sum of luminance; all 0
//               in a cell that stays shut
//      place    formula (1): P0 in pixels from the centre of the cell's first
//               pixel; index of the blur; bright pixels
// CPU twin: group.c
uniform sampler2D sources;
uniform sampler2D parents;
uniform ivec2 origin;
uniform ivec2 size;
uniform ivec2 side;
uniform ivec2 boxes;
uniform float fill;

layout(location = 0) out vec4 light;
layout(location = 1) out vec4 place;

const int BOXES = 10; // GP_BLURS
const int box[BOXES] = int[BOXES](1, 2, 3, 4, 6, 8, 12, 16, 32, 64);

bool is_bright(vec4 pixel)
{
    return any(greaterThan(pixel, vec4(0.0)));
}

// Second moment that box `i` and bilinear sampling at p0 have together.
float spread_of(int i, vec2 p0)
{
    float m = float(box[i]);
    vec2 f = fract(p0 - 0.5 * (m - 1.0));
    return (m * m - 1.0) / 12.0 + 0.5 * dot(f, 1.0 - f);
}

int nearest_box(float spread, vec2 p0)
{
    int best = 0;
    float least = 1e30;
    for (int i = 0; i < BOXES && box[i] <= side.x; i++) {
        float off = abs(spread_of(i, p0) - spread);
        if ((boxes.x >> i & 1) != 0 && off < least) {
            least = off;
            best = i;
        }
    }
    return best;
}

void main()
{
    ivec2 cell = ivec2(gl_FragCoord.xy);
    ivec2 corner = origin + cell * side.x;
    ivec2 low = max(corner, ivec2(0));
    ivec2 high = min(corner + side.x, size);
    light = vec4(0.0);
    place = vec4(0.0);
    if (side.y > 0 && is_bright(texelFetch(parents, cell / side.y, 0)))
        return; // the cluster's polygon replaces this one

    // row by row, which rounds less than one long sum
    vec4 sum = vec4(0.0);
    vec2 moment = vec2(0.0);
    int bright = 0;
    for (int y = low.y; y < high.y; y++) {
        vec4 row = vec4(0.0);
        vec2 along = vec2(0.0);
        for (int x = low.x; x < high.x; x++) {
            vec4 pixel = texelFetch(sources, ivec2(x, y), 0);
            bright += int(is_bright(pixel));
            row += pixel;
            along += pixel.a * vec2(ivec2(x, y) - corner);
        }
        sum += row;
        moment += along;
    }
    ivec2 inside = max(high - low, ivec2(0));
    if (bright == 0 ||
        float(bright) < fill * float(inside.x * inside.y))
        return;

    // again about the mean, which cancels its rounding error
    vec2 mean = vec2(0.5 * float(side.x - 1));
    float spread = 0.0;
    if (sum.a > 0.0) {
        mean = moment / sum.a;
        moment = vec2(0.0);
        for (int y = low.y; y < high.y; y++) {
            vec3 row = vec3(0.0);
            for (int x = low.x; x < high.x; x++) {
                float l = texelFetch(sources, ivec2(x, y), 0).a;
                vec2 d = vec2(ivec2(x, y) - corner) - mean;
                row += l * vec3(d, dot(d, d));
            }
            moment += row.xy;
            spread += row.z;
        }
        mean += moment / sum.a;
        spread *= 0.5 / sum.a; // the mean of x and y
    }
    light = sum;
    place = vec4(mean, float(nearest_box(spread, mean)), float(bright));
}
