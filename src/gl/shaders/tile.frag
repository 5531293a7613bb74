// SPDX-License-Identifier: Apache-2.0
// Polygons gathered per tile: a fragment is a block of 4x2 pixels, which sums
// over the polygons whose glare reaches its tile: none is blended, and one load
// serves several pixels.
//
// in   list      first a texel for each tile, row by row: x its first entry,
//                y the one after its last, as texels of this list; then the
//                entries, two texels each:
//                  rgb light, scene-linear; fraction of x
//                  fraction of y; column and row of the kernel sample that
//                  falls on the tile's first pixel; the pixels of the tile
//                  that are drawn, first + 64 * last of x, and the same of y
//                  times 4096
//      kernel    texel (i, j) is samples 4 i to 4 i + 3 of row j, the same in
//                all planes; with COLOUR it is sample i of the three planes
//      tile      size of a tile in blocks, as logarithms to base 2
//      sums      tiles in a row; texels of the entries of an inner sum
//      WHOLE     defined when all fractions are 0: samples are not mixed
// out  scene-linear planes of the upper and the lower row of the block
// CPU twin: group.c, plain_groups.h of the tests
layout(rgba32f) readonly uniform imageBuffer list;
layout(rgba32f) readonly uniform image2D kernel;
uniform ivec2 tile;
uniform ivec2 sums;

layout(location = 0) out vec4 red_upper;
layout(location = 1) out vec4 red_lower;
layout(location = 2) out vec4 green_upper;
layout(location = 3) out vec4 green_lower;
layout(location = 4) out vec4 blue_upper;
layout(location = 5) out vec4 blue_lower;

struct block {
    vec4 upper, lower; // rows of four pixels
};

// Weights are all over 0 and products are summed as written, so that the
// error of a share stays a few roundings of that share.
vec4 mixed(vec4 a, vec4 b, float t)
{
    precise vec4 sum = a * (1.0 - t) + b * t;
    return sum;
}

#ifndef COLOUR
// Samples of a row for a block's four pixels, from the one of number `from`
// on. A texel outside the image is loaded as 0.
vec4 samples(int from, int row, float fraction)
{
    vec4 a = imageLoad(kernel, ivec2(from >> 2, row));
    vec4 b = imageLoad(kernel, ivec2((from >> 2) + 1, row));
    bvec4 two = bvec4((from & 2) != 0), one = bvec4((from & 1) != 0);
    vec4 c = mix(a, vec4(a.zw, b.xy), two); // eight samples, moved by 0 or 2
    vec2 d = mix(b.xy, b.zw, two.xy);
    vec4 e = mix(c, vec4(c.yzw, d.x), one); // and by 0 or 1
#ifdef WHOLE
    return e;
#else
    return mixed(e, vec4(e.yzw, mix(d.x, d.y, one.x)), fraction);
#endif
}

void shares(ivec2 from, vec2 fraction, out block r, out block g, out block b)
{
    r.upper = samples(from.x, from.y, fraction.x);
    r.lower = samples(from.x, from.y + 1, fraction.x);
#ifndef WHOLE
    vec4 below = samples(from.x, from.y + 2, fraction.x);
    r.upper = mixed(r.upper, r.lower, fraction.y);
    r.lower = mixed(r.lower, below, fraction.y);
#endif
    b = g = r;
}
#else
// A texel outside the image is loaded as 0.
void samples(int from, int row, float fraction, out vec4 pixel[4])
{
    for (int x = 0; x < 4; x++)
        pixel[x] = imageLoad(kernel, ivec2(from + x, row));
#ifndef WHOLE
    vec4 next = imageLoad(kernel, ivec2(from + 4, row));
    for (int x = 0; x < 3; x++)
        pixel[x] = mixed(pixel[x], pixel[x + 1], fraction);
    pixel[3] = mixed(pixel[3], next, fraction);
#endif
}

void shares(ivec2 from, vec2 fraction, out block r, out block g, out block b)
{
    vec4 upper[4], lower[4];
    samples(from.x, from.y, fraction.x, upper);
    samples(from.x, from.y + 1, fraction.x, lower);
#ifndef WHOLE
    vec4 below[4];
    samples(from.x, from.y + 2, fraction.x, below);
    for (int x = 0; x < 4; x++) {
        upper[x] = mixed(upper[x], lower[x], fraction.y);
        lower[x] = mixed(lower[x], below[x], fraction.y);
    }
#endif
    for (int x = 0; x < 4; x++) {
        r.upper[x] = upper[x].r, r.lower[x] = lower[x].r;
        g.upper[x] = upper[x].g, g.lower[x] = lower[x].g;
        b.upper[x] = upper[x].b, b.lower[x] = lower[x].b;
    }
}
#endif

// Leaves the block's pixels, the first at `at` of the tile, that are drawn:
// a negative difference is all ones after the shift.
block cut(ivec2 at, int drawn, block b)
{
    ivec4 x = at.x + ivec4(0, 1, 2, 3);
    ivec2 first = ivec2(drawn, drawn >> 12) & 63;
    ivec2 last = ivec2(drawn >> 6 & 63, drawn >> 18);
    ivec4 sides = ((x - first.x) | (last.x - x)) >> 31;
    int upper = ((at.y - first.y) | (last.y - at.y)) >> 31;
    int lower = ((at.y + 1 - first.y) | (last.y - at.y - 1)) >> 31;
    return block(
        intBitsToFloat(floatBitsToInt(b.upper) & ~(sides | upper)),
        intBitsToFloat(floatBitsToInt(b.lower) & ~(sides | lower)));
}

void add(inout block sum, block b, float light)
{
    precise vec4 upper = sum.upper + light * b.upper;
    precise vec4 lower = sum.lower + light * b.lower;
    sum = block(upper, lower);
}

const block DARK = block(vec4(0.0), vec4(0.0));

void main()
{
    ivec2 here = ivec2(gl_FragCoord.xy), which = here >> tile;
    ivec2 at = (here - (which << tile)) * ivec2(4, 2);
    vec4 range = imageLoad(list, which.y * sums.x + which.x);
    int i = int(range.x), end = int(range.y);
    block red = DARK, green = DARK, blue = DARK;

    while (i < end) {
        block red_part = DARK, green_part = DARK, blue_part = DARK;
        for (int stop = min(i + sums.y, end); i < stop; i += 2) {
            vec4 one = imageLoad(list, i), two = imageLoad(list, i + 1);
            block r, g, b;
            shares(ivec2(two.yz) + at, vec2(one.w, two.x), r, g, b);
            add(red_part, cut(at, int(two.w), r), one.r);
            add(green_part, cut(at, int(two.w), g), one.g);
            add(blue_part, cut(at, int(two.w), b), one.b);
        }
        add(red, red_part, 1.0);
        add(green, green_part, 1.0);
        add(blue, blue_part, 1.0);
    }
    red_upper = red.upper;
    red_lower = red.lower;
    green_upper = green.upper;
    green_lower = green.lower;
    blue_upper = blue.upper;
    blue_lower = blue.lower;
}
