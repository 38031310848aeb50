#pragma once

namespace atropos::render {

/// Vertices to a distorted image whose first row is the framebuffer's first row, so that nothing needs
/// flipping. Between vertices edges stay straight: meshes are split finely enough before (see GpuMesh).
inline constexpr const char* kSceneVertexShader = R"glsl(
layout(location = 0) in vec3 a_position;
layout(location = 1) in vec3 a_normal;
layout(location = 2) in vec2 a_uv;
layout(location = 3) in vec3 a_tangent;
uniform mat4 u_X_EM;             // mesh to eye, m
uniform vec4 u_intrinsics;       // 2 fx / w, 2 fy / h, and the image centre's clip offset
uniform float u_distortion[8];   // k1 k2 p1 p2 k3 k4 k5 k6
uniform float u_r2_max;          // beyond it the radial factor is kept, lest the image folds
uniform vec2 u_depth_range;      // clip z = x * depth + y
out vec3 v_position;
out vec3 v_normal;
out vec2 v_uv;
out vec3 v_tangent;

void main() {
    vec3 p = (u_X_EM * vec4(a_position, 1.0)).xyz;
    vec2 d = p.xy;
#ifdef DISTORTED
    float r2 = p.z > 1e-6 ? min(dot(p.xy, p.xy) / (p.z * p.z), u_r2_max) : u_r2_max;
    float radial = (1.0 + r2 * (u_distortion[0] + r2 * (u_distortion[1] + r2 * u_distortion[4]))) /
                   (1.0 + r2 * (u_distortion[5] + r2 * (u_distortion[6] + r2 * u_distortion[7])));
    d *= radial;
    if (r2 < u_r2_max) {
        vec2 n = p.xy / p.z;
        d += p.z * vec2(2.0 * u_distortion[2] * n.x * n.y + u_distortion[3] * (r2 + 2.0 * n.x * n.x),
                        u_distortion[2] * (r2 + 2.0 * n.y * n.y) + 2.0 * u_distortion[3] * n.x * n.y);
    }
#endif
    gl_Position = vec4(u_intrinsics.xy * d + u_intrinsics.zw * p.z, u_depth_range.x * p.z + u_depth_range.y, p.z);
    v_position = p;
    v_normal = mat3(u_X_EM) * a_normal;
    v_uv = a_uv;
    v_tangent = mat3(u_X_EM) * a_tangent;
}
)glsl";

/// Metallic-roughness GGX (Walter et al. 2007; Smith's visibility in Schlick's form as in Karis 2013), lit by
/// the lamp at the endoscope's tip; colour, depth and label in one pass.
inline constexpr const char* kSceneFragmentShader = R"glsl(
in vec3 v_position;
in vec3 v_normal;
in vec2 v_uv;
in vec3 v_tangent;
uniform vec3 u_base_colour;
uniform vec4 u_surface;          // metallic, roughness, F0 of the dielectric part, wetness
uniform vec3 u_light_position;   // in the eye's frame
uniform vec3 u_light_axis;
uniform vec4 u_light;            // intensity * reference^2, cos outer, 1 / (cos inner - cos outer), ambient
uniform uint u_label;
uniform sampler2D u_colour_map;
uniform sampler2D u_normal_map;
#ifdef SHADOWS
uniform mat4 u_X_SE;             // eye to shadow clip space
uniform sampler2DShadow u_shadow_map;
#endif
layout(location = 0) out vec4 o_colour;
layout(location = 1) out float o_depth;
layout(location = 2) out uint o_label;

float ggx(float nh, float nl, float nv, float alpha) {  // distribution times visibility times pi
    float a2 = alpha * alpha;
    float q = nh * nh * (a2 - 1.0) + 1.0;
    float k = 0.5 * alpha;
    return a2 / (q * q * 4.0 * (nl * (1.0 - k) + k) * (nv * (1.0 - k) + k));
}

// Light from the rest of the cavity: lit tissue ahead, the dark way back to the ports behind, fading with roughness.
vec3 cavity(vec3 r, float roughness) {
    float ahead = smoothstep(-0.35 - roughness, 0.45 + roughness, r.z);
    float above = smoothstep(-0.5 - roughness, 0.5 + roughness, -r.y);
    vec3 walls = mix(vec3(0.030, 0.020, 0.020), vec3(0.40, 0.23, 0.20), ahead);
    return walls * (0.65 + 0.7 * above);
}

void main() {
    vec3 base = u_base_colour;
    float roughness = u_surface.y;
    vec3 smooth_n = normalize(v_normal);
    vec3 n = smooth_n;
#ifdef TEXTURED
    vec3 root = texture(u_colour_map, v_uv).rgb;  // coded by a square root
    base *= root * root;
    vec4 bump = texture(u_normal_map, v_uv, -1.0);
    vec3 t = normalize(v_tangent - n * dot(n, v_tangent));
    vec3 b = cross(n, t);
    bump.xyz = bump.xyz * 2.0 - 1.0;
    n = normalize(bump.x * t + bump.y * b + bump.z * n);
    roughness *= bump.w;
#endif
    vec3 v = -normalize(v_position);
    vec3 to_light = u_light_position - v_position;
    float inverse_d2 = 1.0 / dot(to_light, to_light);
    vec3 l = to_light * sqrt(inverse_d2);
    float cone = clamp((-dot(l, u_light_axis) - u_light.y) * u_light.z, 0.0, 1.0);
    float incoming = u_light.x * inverse_d2;
    float direct = incoming * cone * cone * (3.0 - 2.0 * cone);
#ifdef SHADOWS
    vec4 s = u_X_SE * vec4(v_position + smooth_n * 2e-4, 1.0);
    vec3 q = s.xyz / s.w * 0.5 + 0.5;
    vec2 texel = 0.75 / vec2(textureSize(u_shadow_map, 0));
    q.z -= 2e-5;
    direct *= 0.25 * (texture(u_shadow_map, q + vec3(texel.x, texel.y, 0.0)) +
                      texture(u_shadow_map, q + vec3(-texel.x, texel.y, 0.0)) +
                      texture(u_shadow_map, q + vec3(texel.x, -texel.y, 0.0)) +
                      texture(u_shadow_map, q + vec3(-texel.x, -texel.y, 0.0)));
#endif
    vec3 h = normalize(l + v);
    float nl = dot(n, l), nv = max(dot(n, v), 1e-3);
    float nl0 = max(nl, 0.0);
    vec3 f0 = mix(vec3(u_surface.z), base, u_surface.x);
    vec3 diffuse = base * (1.0 - u_surface.x);
    float grazing = 1.0 - max(dot(h, v), 0.0);
    float grazing5 = grazing * grazing * grazing * grazing * grazing;
    vec3 fresnel = f0 + (1.0 - f0) * grazing5;
    float alpha = roughness * roughness;
#ifdef WET
    // A film of fluid mirrors the lamp on every wrinkle. Light scattered below it evens them out, softens the
    // terminator, red most.
    vec3 colour = u_surface.w * fresnel * (min(ggx(max(dot(n, h), 0.0), nl0, nv, 0.06 + 0.4 * alpha), 120.0) * nl0);
    vec3 wrap = u_surface.w * vec3(0.30, 0.10, 0.07);
    float soft_nl = dot(normalize(smooth_n + n), l);
    colour += diffuse * max((soft_nl + wrap) / (1.0 + wrap), 0.0);
#else
    vec3 colour = fresnel * (min(ggx(max(dot(n, h), 0.0), nl0, nv, alpha), 30.0) * nl0) + diffuse * nl0;
#endif
    colour *= direct;
    vec3 r = reflect(-v, n);
    float rim = 1.0 - nv;
    rim *= rim * rim;
    colour += incoming * u_light.w * (diffuse * vec3(1.15, 0.90, 0.88) +
              8.0 * (f0 + (max(vec3(1.0 - roughness), f0) - f0) * rim * rim) * cavity(r, roughness));
    o_colour = vec4(colour, 1.0);
    o_depth = v_position.z;
    o_label = u_label;
}
)glsl";

/// Depth alone, seen from the lamp.
inline constexpr const char* kShadowVertexShader = R"glsl(
layout(location = 0) in vec3 a_position;
uniform mat4 u_X_SM;
void main() { gl_Position = u_X_SM * vec4(a_position, 1.0); }
)glsl";

inline constexpr const char* kShadowFragmentShader = R"glsl(
void main() {}
)glsl";

}  // namespace atropos::render
