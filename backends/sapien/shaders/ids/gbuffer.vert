#version 450
// Where the camera sees a vertex, and how far away along its axis.

#include "../camera.glsl"
#include "../object.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;

layout(location = 0) out float away;
layout(location = 1) out flat uint number;

void main() {
  vec4 seen = camera.viewMatrix * transform.modelMatrix * vec4(position, 1);
  away = -seen.z;
  number = object.segmentation.y;
  gl_Position = camera.projectionMatrix * seen;
}
