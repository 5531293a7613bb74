// The glare image on an open polygon (Ando et al. 2007, section 3.2) that lies
// on whole pixels: each pixel has its own kernel texel and none is filtered.
//
// in   kernel   share of a source's light that falls on each pixel
//      light    of the polygon, scene-linear rgb
//      corner   target pixel of kernel texel (0, 0)
// out  scene-linear rgb to be added to the target; a is not used
// CPU twin: direct.c, the innermost loop
uniform sampler2D kernel;

flat in vec3 light;
flat in ivec2 corner;

out vec4 glare;

void main()
{
    vec3 share = texelFetch(kernel, ivec2(gl_FragCoord.xy) - corner, 0).rgb;
    glare = vec4(light * share, 0.0);
}
