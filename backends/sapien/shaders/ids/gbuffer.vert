#version 450
// Where the camera sees a vertex, and how far away along its axis.

#include "../camera.glsl"
#include "../object.glsl"
#include "../vertex.glsl"

layout(location = 0) out float away;
layout(location = 1) out flat uint number;

void main() {
  vec4 seen = camera.viewMatrix * transform.modelMatrix * vec4(position, 1);
  away = -seen.z;
  number = object.segmentation.y;
  gl_Position = camera.projectionMatrix * seen;
}
