// SPDX-License-Identifier: Apache-2.0
// Texels of sun maps to be added up (Maughan, step 4). Instance = texel of every
// map: a triangle over the whole target, which has a pixel for each light in rows
// as the atlas has maps, stands for a point in each of them.
//
// in   map    x: texels of a map's side
// out  texel  of every map
// CPU twin: mask.c, gp_sun_map_reference()
uniform ivec2 map;

flat out ivec2 texel;

void main()
{
    texel = ivec2(gl_InstanceID % map.x, gl_InstanceID / map.x);
    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0,
                       gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
