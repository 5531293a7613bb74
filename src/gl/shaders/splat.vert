// Glare sensors: one degenerate quad for each pixel of a block of sources
// (Ando et al. 2007, section 3.1). A bright sensor opens its quad to the
// kernel's size, a dark one leaves all corners in one point.
//
// in   sources   texel = one sensor: rgb light after the bright pass
//                (scene-linear), a the largest of the three
//      kernel    only its size, in pixels
//      offset    corner of sensor (0, 0)'s open quad, in target pixels
//      block     columns and rows of sensors in use
//      range     first sensor and the one after the last, in row order
//      target    size in pixels
// out  quads cut to the target, so that none leaves the clip volume
// CPU twin: direct.c, the loop over sources and their boxes
uniform sampler2D sources;
uniform sampler2D kernel;
uniform ivec2 offset;
uniform ivec2 block;
uniform ivec2 range;
uniform ivec2 target;

flat out vec3 light;   // of the source
flat out ivec2 corner; // target pixel of kernel texel (0, 0)

const int QUADS = 64; // of one instance; the same as in splat.c

void main()
{
    int sensor = range.x + gl_InstanceID * QUADS + gl_VertexID / 6;
    ivec2 at = ivec2(sensor % block.x, sensor / block.x);
    vec4 found = vec4(0.0);
    if (sensor < range.y)
        found = texelFetch(sources, at, 0);

    light = found.rgb;
    corner = at + offset;
    ivec2 low = clamp(corner, ivec2(0), target);
    ivec2 high = clamp(corner + textureSize(kernel, 0), ivec2(0), target);
    ivec2 open = found.a > 0.0 ? high - low : ivec2(0);
    gl_Position = clip_of_corner(low + open * quad_corner(gl_VertexID % 6),
                                 target);
}
