// SPDX-License-Identifier: Apache-2.0
// Adds a point of each light's sun map to the light's pixel of the intensity map: a
// texel or, where they are more, the mean of four.
//
// in   atlas  sun maps side by side; r share shown, g weight
//      map    x: texels of a map's side; y: points
//      texel  of every map, the first one of a point
//   BYTE:
//      scale  of the 8-bit sum: 1 / 255 for a map of 256 texels
// out  to be added: r and g in 256ths, which add up exactly in a float target
//      (65536 texels at most), and in b and a the rest of each.
//      BYTE: r and g times scale, for an 8-bit target
// CPU twin: mask.c, gp_sun_map_reference()
uniform sampler2D atlas;
uniform ivec2 map;

flat in ivec2 texel;

out vec4 sum;

vec2 value()
{
    ivec2 at = ivec2(gl_FragCoord.xy) * map.x + texel;
    vec2 v = texelFetch(atlas, at, 0).rg;
    if (map.y < map.x)
        v = 0.25 * (v + texelFetch(atlas, at + ivec2(1, 0), 0).rg +
                    texelFetch(atlas, at + ivec2(0, 1), 0).rg +
                    texelFetch(atlas, at + ivec2(1, 1), 0).rg);
    return v;
}

#ifdef BYTE

uniform float scale;

// Quarters that 8 bits would all round to one side are 1 as often as they are large.
const vec4 DITHER = vec4(-3.0, 1.0, 3.0, -1.0) / (8.0 * 255.0);

void main()
{
    ivec2 at = texel * map.y / map.x & 1;
    vec2 dither = vec2(map.y < map.x ? DITHER[at.x + 2 * at.y] : 0.0);
    sum = vec4(max(value() * scale + dither, 0.0), 0.0, 0.0);
}

#else

void main()
{
    vec2 v = value();
    vec2 most = floor(v * 256.0) / 256.0;
    sum = vec4(most, v - most);
}

#endif
