// Images of lens-flare elements: a quad for each of each light, shut where the
// light is hidden (Maughan 2002: the intensity map is fetched, and nothing is
// read back).
//
// in   quads      five texels each, quad after quad, row after row:
//                 0  target pixels of the element's rect, before `field`
//                 1  first pixel's centre less the place; cosine and sine
//                 2  IMAGE: texels a pixel; PLAIN: texel of the rect's corner;
//                    the light's number
//                 3  IMAGE: the place in texels; PLAIN: part of a texel
//                 4  amount of each channel
//      intensity  texel (i, 0) of light i: visibility = r / g, 0 where g is 0
//      first      x: first quad of the draw
//      field      pixel of the rects' coordinates at the target's corner
//      size       of the target
// out  quads cut to the target
// CPU twin: flare_image.c
uniform sampler2D quads;
uniform sampler2D intensity;
uniform ivec2 first;
uniform ivec2 field;
uniform ivec2 size;

flat out ivec2 origin; // target pixel of the rect's corner
flat out vec2 base;    // its centre less the place
flat out vec2 turn;
flat out vec3 radius;
flat out vec3 inner;
flat out vec3 light;   // at a sample of 1

const int TEXELS = 5; // the same as in flare_gl.c

vec4 quad_texel(int quad, int k)
{
    int rows = textureSize(quads, 0).y;
    return texelFetch(quads, ivec2(quad / rows * TEXELS + k, quad % rows), 0);
}

void main()
{
    int quad = first.x + gl_InstanceID;
    vec4 rect = quad_texel(quad, 0);
    vec4 place = quad_texel(quad, 1);
    vec4 far = quad_texel(quad, 2);
    vec4 near = quad_texel(quad, 3);
    vec4 amount = quad_texel(quad, 4);
    vec2 shown = texelFetch(intensity, ivec2(int(far.a), 0), 0).rg;
    float visibility = shown.g > 0.0 ? shown.r / shown.g : 0.0;

    origin = ivec2(rect.xy) - field;
    base = place.xy;
    turn = place.zw;
    radius = far.rgb;
    inner = near.rgb;
    light = amount.rgb * visibility;

    ivec2 corner = quad_corner(gl_VertexID);
    if (!(visibility > 0.0)) {
        gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
        return;
    }
    ivec2 low = clamp(origin, ivec2(0), size);
    ivec2 high = clamp(ivec2(rect.zw) - field, ivec2(0), size);
    gl_Position = clip_of_corner(low + (high - low) * corner, size);
}
