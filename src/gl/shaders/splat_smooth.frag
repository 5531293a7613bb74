// The glare image on an open polygon that lies anywhere, by bilinear samples.
// The four texels are weighted here: a GPU's own filter has weights of 8 bits.
//
// in   kernel    share of a polygon's light, in a border of one texel of 0
//      light     of the polygon, scene-linear rgb
//      corner    target pixel of kernel pixel (0, 0), which is texel (1, 1)
//      fraction  of a pixel that the kernel lies right of and below that
// out  scene-linear rgb to be added to the target; a is not used
// CPU twin: plain_groups.h of the tests
uniform sampler2D kernel;

flat in vec3 light;
flat in ivec2 corner;
flat in vec2 fraction;

out vec4 glare;

void main()
{
    ivec2 t = ivec2(gl_FragCoord.xy) - corner;
    vec3 upper = mix(texelFetch(kernel, t + ivec2(1, 0), 0).rgb,
                     texelFetch(kernel, t, 0).rgb, fraction.x);
    vec3 lower = mix(texelFetch(kernel, t + ivec2(1, 1), 0).rgb,
                     texelFetch(kernel, t + ivec2(0, 1), 0).rgb, fraction.x);
    glare = vec4(light * mix(lower, upper, fraction.y), 0.0);
}
