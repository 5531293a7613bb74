// SPDX-License-Identifier: Apache-2.0
// One triangle that covers the target.
//
// in   nothing; draw 3 vertices
// out  clip coordinates
// CPU twin: none, it only covers
void main()
{
    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0,
                       gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
