#version 450
// Matte surfaces in the sun (light 0, with shadows) and under the sky (light 1 and the ambient light).
// Colours are added up as they are given, in sRGB, as the other engines do; alpha tells a body from the background.

#include "../camera.glsl"
#include "../material.glsl"
#include "../lights.glsl"
#include "../shadows.glsl"

layout(location = 0) centroid in vec3 place;
layout(location = 1) centroid in vec3 upright;
layout(location = 2) centroid in vec2 st;

layout(location = 0) out vec4 outPicture;

const float BIAS = 1, STEEPEST = 4;

// The share of the four texels around `at` that are not nearer to the sun, by their distance from it.
float around(vec2 at, float away) {
  vec2 between = fract(at * textureSize(samplerDirectionalLightDepths[0], 0) + 0.5);
  vec4 lit = step(away, textureGather(samplerDirectionalLightDepths[0], at));
  return mix(mix(lit.w, lit.z, between.x), mix(lit.x, lit.y, between.x), between.y);
}

// How much of the sun reaches this place, which is turned to it by the cosine `slant`: 0..1.
float sunlight(float slant) {
  LightBuffer sun = shadow.directionalLightBuffers[0];
  vec3 seen = (sun.projectionMatrix * sun.viewMatrix * vec4(place, 1)).xyz;
  vec2 half_texel = 0.5 / textureSize(samplerDirectionalLightDepths[0], 0);
  // What is thinner than a texel would shade itself: a place counts as nearer by a texel, and by what the surface falls
  // away beside it. The map is orthographic, and as wide as high.
  float steep = min(sqrt(1 - slant * slant) / slant, STEEPEST);
  float texel = 4 * half_texel.x / sun.projectionMatrix[0][0] * abs(sun.projectionMatrix[2][2]);
  seen.z -= texel * (BIAS + steep);
  vec2 at = seen.xy * 0.5 + 0.5;
  return 0.25 * (around(at + half_texel * vec2(-1, -1), seen.z) + around(at + half_texel * vec2(1, -1), seen.z)
    + around(at + half_texel * vec2(-1, 1), seen.z) + around(at + half_texel * vec2(1, 1), seen.z));
}

void main() {
  vec3 eye = camera.viewMatrixInverse[3].xyz;
  vec3 facing = faceforward(normalize(upright), place - eye, upright);
  vec3 slant = vec3(max(dot(facing, -scene.directionalLights[0].direction.xyz), 0));
  vec3 light = scene.ambientLight.rgb + slant * scene.directionalLights[1].emission.rgb;
  if (slant.x > 0) light += sunlight(slant.x) * slant * scene.directionalLights[0].emission.rgb;
  vec3 color = material.baseColor.rgb;
  if ((material.textureMask & 1) != 0) color *= texture(colorTexture, st).rgb;
  outPicture = vec4(color * light, 1);
}
