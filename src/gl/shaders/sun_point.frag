// SPDX-License-Identifier: Apache-2.0
// Adds a point of each light's sun map to the light's pixel of the intensity map: a
// texel or, where they are more, the mean of a square of them.
//
// in   atlas  sun maps side by side; r share shown, g weight
//      map    x: texels of a map's side; y: points
//      texel  of every map, the first one of a point
//   BYTE:
//      scale  of the 8-bit sum: 1 / 255 for 256 points
// out  to be added: r and g in 256ths, which add up exactly in a float target
//      (65536 texels at most), and in b and a the rest of each.
//      BYTE: r and g times scale, for an 8-bit target, twice: greys that one half
//      rounds up the other rounds down
// CPU twin: mask.c, gp_sun_map_reference()
uniform sampler2D atlas;
uniform ivec2 map;

flat in ivec2 texel;

out vec4 sum;

vec2 value()
{
    ivec2 at = ivec2(gl_FragCoord.xy) * map.x + texel;
    int wide = map.x / map.y;
    vec2 v = vec2(0.0);
    for (int i = 0; i < wide * wide; i++)
        v += texelFetch(atlas, at + ivec2(i % wide, i / wide), 0).rg;
    return v / float(wide * wide);
}

#ifdef BYTE

uniform float scale;

void main()
{
    // greys, which 8 bits would all round to one side, are 1 as often as they are
    // large: evenly over neighbours by the plastic number (Roberts 2018)
    vec2 at = vec2(texel / (map.x / map.y) + 1);
    float turn = fract(dot(at, vec2(0.7548777, 0.5698403)));
    float dither = (floor(16.0 * turn) - 7.5) / (16.0 * 255.0);
    sum = max(vec4(value() * scale + dither, value() * scale - dither), 0.0);
}

#else

void main()
{
    vec2 v = value();
    vec2 most = floor(v * 256.0) / 256.0;
    sum = vec4(most, v - most);
}

#endif
