#version 450
// Where the camera sees a vertex, and what its fragments need to be lit, in the world's frame.

#include "../camera.glsl"
#include "../object.glsl"
#include "../vertex.glsl"

layout(location = 0) centroid out vec3 place;
layout(location = 1) centroid out vec3 upright;
layout(location = 2) centroid out vec2 st;

void main() {
  vec4 world = transform.modelMatrix * vec4(position, 1);
  place = world.xyz;
  upright = mat3(transform.modelMatrix) * normal;  // bodies are rigid: the matrix only turns and moves
  st = uv;
  gl_Position = camera.projectionMatrix * camera.viewMatrix * world;
}
