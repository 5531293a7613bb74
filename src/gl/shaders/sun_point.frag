// SPDX-License-Identifier: Apache-2.0
// Adds a texel of each light's sun map to the light's pixel of the intensity map.
//
// in   atlas  sun maps side by side; r share shown, g weight
//      map    x: texels of a map's side
//      texel  of every map
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
    return texelFetch(atlas, ivec2(gl_FragCoord.xy) * map.x + texel, 0).rg;
}

#ifdef BYTE

uniform float scale;

void main()
{
    sum = vec4(value() * scale, 0.0, 0.0);
}

#else

void main()
{
    vec2 v = value();
    vec2 most = floor(v * 256.0) / 256.0;
    sum = vec4(most, v - most);
}

#endif
