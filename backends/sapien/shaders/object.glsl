// One body, as SAPIEN fills it in (the names are its); `segmentation.y` is the number of its entity.
layout(set = 1, binding = 0) uniform ObjectTransformBuffer {
  mat4 modelMatrix;
} transform;

layout(set = 1, binding = 1) uniform ObjectDataBuffer {
  uvec4 segmentation;
  float transparency;
  int shadeFlat;
} object;
