// The lights, as SAPIEN fills them in (the names are its); it wants every kind declared, used or not.
struct PointLight { vec4 position; vec4 emission; };
struct DirectionalLight { vec4 direction; vec4 emission; };
struct SpotLight { vec4 position; vec4 direction; vec4 emission; };

layout(set = 3, binding = 0) uniform SceneBuffer {
  vec4 ambientLight;
  PointLight pointLights[1];
  DirectionalLight directionalLights[2];
  SpotLight spotLights[1];
  SpotLight texturedLights[1];
} scene;
