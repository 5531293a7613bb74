// Intensity map from the sums of the points: one texel a light.
//
// in   sums   as sun_point.frag leaves them
//      map    y: lights in a row of them
//      scale  1 / count of a map's texels; 1 for 8-bit sums
// out  r share shown times g, g weight; visibility = r / g
// CPU twin: map.c, gp_sun_map_reference()
uniform sampler2D sums;
uniform ivec2 map;
uniform float scale;

out vec4 intensity;

void main()
{
    int light = int(gl_FragCoord.x);
    vec4 sum = texelFetch(sums, ivec2(light % map.y, light / map.y), 0);
    intensity = vec4((sum.rg + sum.ba) * scale, 0.0, 0.0);
}
