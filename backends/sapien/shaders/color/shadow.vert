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
#include "../vertex.glsl"

void main() {
  gl_Position = light.projectionMatrix * light.viewMatrix * transform.modelMatrix * vec4(position, 1);
}
