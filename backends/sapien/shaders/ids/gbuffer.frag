#version 450
// The distance of what is seen and the number of its body; 0 for the background.

#include "../camera.glsl"
#include "../material.glsl"
#include "../lights.glsl"

layout(location = 0) in float away;
layout(location = 1) in flat uint number;

layout(location = 0) out vec4 outSeen;

void main() {
  outSeen = vec4(away, number, 0, 1);  // opaque: targets are blended
}
