// The maps of what each light sees, as SAPIEN fills them in (the names are its); it wants every kind declared.
struct LightBuffer {
  mat4 viewMatrix;
  mat4 viewMatrixInverse;
  mat4 projectionMatrix;
  mat4 projectionMatrixInverse;
  int width;
  int height;
};

layout(set = 3, binding = 1) uniform ShadowBuffer {
  LightBuffer pointLightBuffers[6];
  LightBuffer directionalLightBuffers[1];
  LightBuffer spotLightBuffers[1];
  LightBuffer texturedLightBuffers[1];
} shadow;

layout(set = 3, binding = 2) uniform samplerCube samplerPointLightDepths[1];
layout(set = 3, binding = 3) uniform sampler2D samplerDirectionalLightDepths[1];
layout(set = 3, binding = 4) uniform sampler2D samplerSpotLightDepths[1];
layout(set = 3, binding = 5) uniform sampler2D samplerTexturedLightDepths[1];
layout(set = 3, binding = 6) uniform sampler2D samplerTexturedLightTextures[1];
