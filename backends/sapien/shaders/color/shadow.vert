#version 450
// Where the sun sees a vertex.

layout(set = 0, binding = 0) uniform LightBuffer {
  mat4 viewMatrix;
  mat4 viewMatrixInverse;
  mat4 projectionMatrix;
  mat4 projectionMatrixInverse;
  int width;
  int height;
} light;

#include "../object.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;

void main() {
  gl_Position = light.projectionMatrix * light.viewMatrix * transform.modelMatrix * vec4(position, 1);
}
