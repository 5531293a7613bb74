// Adds a point to each light's pixel of the sums.
//
// in   atlas  sun maps side by side; r share shown, g weight
//      map    x: texels of a map's side
//      texel  of the map; BILINEAR: corner between the 2 x 2 texels, whose
//             mean by the texture's filter is taken
//   BYTE:
//      scale  of the 8-bit sum: 1 / 255 for a map of 256 texels
// out  to be added: r and g in 256ths, which add up exactly in a float target
//      (65536 texels at most), and in b and a the rest of each.
//      BYTE: r and g times scale, for an 8-bit target
// CPU twin: map.c, gp_sun_map_reference()
uniform sampler2D atlas;
uniform ivec2 map;

flat in ivec2 texel;

out vec4 sum;

vec2 value()
{
    ivec2 at = ivec2(gl_FragCoord.xy) * map.x + texel;
#ifdef BILINEAR
    return 4.0 * textureLod(atlas, vec2(at) / vec2(textureSize(atlas, 0)),
                            0.0).rg;
#else
    return texelFetch(atlas, at, 0).rg;
#endif
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
