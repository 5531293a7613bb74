// SPDX-License-Identifier: Apache-2.0
// A square of a target for each light: its sun map in the atlas or, with PIXELS
// defined, the region of one light. Instance = light.
//
// in   lights  row = one light: texels 0 to 3 are place, extent, kept and beyond
//              of sun_map.frag
//      light   x: row of instance 0
//      map     texels of a square's side, squares in a row of the target
//      size    of the target's texture
// out  clip coordinates, and the light's inputs of sun_map.frag
// CPU twin: mask.c, gp_sun_map_reference()
uniform sampler2D lights;
uniform ivec2 light;
uniform ivec2 map;
uniform ivec2 size;

flat out vec4 place;
flat out vec4 extent;
flat out ivec4 kept;
flat out vec2 beyond;
flat out ivec2 corner;

void main()
{
    int i = light.x + gl_InstanceID;
    place = texelFetch(lights, ivec2(0, i), 0);
    extent = texelFetch(lights, ivec2(1, i), 0);
    kept = ivec4(texelFetch(lights, ivec2(2, i), 0));
    beyond = texelFetch(lights, ivec2(3, i), 0).xy;
    corner = ivec2(gl_InstanceID % map.y, gl_InstanceID / map.y) * map.x;
    gl_Position = clip_of_corner(corner + map.x * quad_corner(gl_VertexID),
                                 size);
}
