// A vertex, in the body's frame. SAPIEN wants all shaders of a process to declare the same, and its own declare this.
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;
layout(location = 3) in vec3 tangent;
layout(location = 4) in vec3 bitangent;
