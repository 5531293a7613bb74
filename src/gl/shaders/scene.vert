// SPDX-License-Identifier: Apache-2.0
// Triangles of a scene's mesh in their place: for the picture, or for a light's
// map of shadows.
//
// in   vertices  two texels each: place in the mesh and u; normal and v
//      to_clip   the mesh to clip coordinates, of the picture or of a map
// CUBE, the six squares of a point's map, 3 x 2 of them:
//      to_light  the mesh to the light: its axes are the world's
//      faces     x: bits of the faces to draw, an instance each
//      map       x: texels of a square's side; y: its near plane
// LIT, the pass of a light:
//      to_light  as above
//      normals   normals of the mesh to the world
// out  place, from the light, and normal (LIT); uv (HOLES)
// CPU twin: relight.c, which lights pixels by rays
uniform samplerBuffer vertices;
#ifdef CUBE
uniform ivec2 faces;
uniform vec4 map;
out float gl_ClipDistance[4];
#else
uniform mat4 to_clip;
invariant gl_Position;
#endif
#if defined(CUBE) || defined(LIT)
uniform mat4 to_light;
#endif
#ifdef LIT
uniform mat4 normals;
out vec3 place;
out vec3 normal;
#endif
#ifdef HOLES
out vec2 uv;
#endif

void main()
{
    vec4 first = texelFetch(vertices, 2 * gl_VertexID);
    vec4 second = texelFetch(vertices, 2 * gl_VertexID + 1);
    vec4 p = vec4(first.xyz, 1.0);
#ifdef HOLES
    uv = vec2(first.w, second.w);
#endif
#ifdef LIT
    place = (to_light * p).xyz;
    normal = (normals * vec4(second.xyz, 0.0)).xyz;
#endif
#ifdef CUBE
    int face = findLSB(faces.x);
    int left = faces.x;
    for (int i = 0; i < gl_InstanceID; i++)
        left &= left - 1;
    face = findLSB(left);
    vec3 q = (to_light * p).xyz;
    int axis = face >> 1;
    // a texel of the neighbours around each square
    float k = (map.x - 2.0) / map.x;
    vec2 xy = k * (axis == 0 ? q.yz : axis == 1 ? q.zx : q.xy);
    float m = (face & 1) == 0 ? q[axis] : -q[axis];
    gl_ClipDistance[0] = m - xy.x;
    gl_ClipDistance[1] = m + xy.x;
    gl_ClipDistance[2] = m - xy.y;
    gl_ClipDistance[3] = m + xy.y;
    vec2 square = vec2(2 * (face % 3) - 2, 2 * (face / 3) - 1);
    gl_Position = vec4((xy + square * m) / vec2(3.0, 2.0), map.y, m);
#else
    gl_Position = to_clip * p;
#endif
}
