// Glare sensors whose open quads turn with the kernel (Ando et al. 2007,
// section 5: rotation by the vertex shader, at almost no cost). The kernel
// stays as it was before it was turned.
//
// in   sensors   texel = one pixel: rgb light (scene-linear), a its luminance
//      reaches   by gp_source_bin(L0): pixels from the sensor to the edge
//      cells     columns and rows of sensors in use
//      range     first sensor and the one after the last, in row order
//      offset    target pixel of sensor (0, 0)
//      extent    columns and rows of the kernel
//      centre    of the kernel, in its pixels
//      turn      cosine and sine of the angle
//      shrinks   x: 1 when quads shrink
//      view      corner of the view in target pixels
//      viewed    its size; the open quads that meet the target lie inside
// out  quads around the kernel and its border of zeros
// CPU twin: direct.c with the rotated kernel, gp_rotate()
uniform sampler2D sensors;
layout(std140) uniform reaches
{
    vec4 reach[128];
};
uniform ivec2 cells;
uniform ivec2 range;
uniform ivec2 offset;
uniform ivec2 extent;
uniform ivec2 centre;
uniform vec2 turn;
uniform ivec2 shrinks;
uniform ivec2 view;
uniform ivec2 viewed;

flat out vec3 light;   // of the source
flat out ivec2 middle; // target pixel of the source
flat out int far;      // pixels from there that are drawn

const int QUADS = 64;     // of one instance; the same as in splat/draw.c
const float MORE = 0.125; // pixels; the rasterizer rounds to 1/256

void main()
{
    int sensor = range.x + gl_InstanceID * QUADS + gl_VertexID / 6;
    ivec2 at = ivec2(sensor % cells.x, sensor / cells.x);
    vec4 found = vec4(0.0);
    if (sensor < range.y)
        found = texelFetch(sensors, at, 0);
    bool open = any(greaterThan(found, vec4(0.0)));
    light = found.rgb;
    middle = at + offset;
    far = 1 << 20;
    vec2 low = vec2(-centre) - 1.0;
    vec2 high = vec2(extent - centre);
    if (open && shrinks.x > 0) {
        int bin = floatBitsToInt(found.a) >> 22 & 511;
        far = int(reach[bin >> 2][bin & 3]);
        float half_side = float(far) * (abs(turn.x) + abs(turn.y));
        low = max(low, vec2(-half_side));
        high = min(high, vec2(half_side));
    }
    vec2 place = vec2(0.0);
    if (open) {
        // corner of the quad in the kernel, turned back into the picture
        vec2 d = mix(low - MORE, high + MORE,
                     vec2(quad_corner(gl_VertexID % 6)));
        place = vec2(turn.x * d.x + turn.y * d.y,
                     turn.x * d.y - turn.y * d.x);
    }
    place += vec2(middle - view) + 0.5;
    gl_Position = vec4((2.0 * place - vec2(viewed)) / vec2(viewed), 0.0, 1.0);
}
