#include "src/gl/shaders/shaders.h"

#include <fmt/format.h>

#include <utility>

#include "src/gl/shaders/shader_text.h"

namespace sluice {
namespace {

constexpr const char* kVersion = "#version 330 core\n";

std::string definitions(const ShaderVariant& v) {
  const std::pair<const char*, int> numbers[] = {{"COMBINING", static_cast<int>(v.combining)},
                                                 {"PERSPECTIVE", v.perspective},
                                                 {"LIT", v.lit},
                                                 {"WITH_DEPTH", v.with_depth},
                                                 {"STOPS_EARLY", v.stops_early},
                                                 {"CLIP_PLANES", v.clip_planes},
                                                 {"FLOATS", v.floats},
                                                 {"COUNTS_TAKEN", v.counts_taken},
                                                 {"GRADIENTS", v.lit || v.gradient_rows > 0},
                                                 {"GRADIENT_ROWS", v.gradient_rows},
                                                 {"FACTOR_TABLE", v.factor_table},
                                                 {"CORRECTS", v.corrects},
                                                 {"SHININESS", v.shininess},
                                                 {"GOES_AHEAD", v.goes_ahead},
                                                 {"LABELS", v.labels},
                                                 {"PLANES", v.planes},
                                                 {"CODES_DEPTH", v.codes_depth},
                                                 {"SCALED", v.scaled},
                                                 {"SPREAD", v.spread},
                                                 {"SHARES", v.shares},
                                                 {"INTEGRATES", v.integrates},
                                                 {"SURFACES", v.surfaces},
                                                 {"HAS_OPACITIES", v.has_opacities},
                                                 {"LIGHT_VOLUME", v.light_volume},
                                                 {"CUES_DEPTH", v.cues_depth},
                                                 {"JITTERS", v.jitters},
                                                 {"OBLIQUE", v.oblique}};
  std::string lines;
  for (const auto& [name, value] : numbers) lines += fmt::format("#define {} {}\n", name, value);
  return lines;
}

}  // namespace

std::string vertexShader(const ShaderVariant& variant) {
  return kVersion + definitions(variant) + "#define FLAT flat out\n" + kInputsText + kVertexText;
}

std::string fragmentShader(const ShaderVariant& variant) {
  return kVersion + definitions(variant) + "#define FLAT flat in\n" + kInputsText + kIntervalText +
         kPlanesText +
         (variant.counts ? std::string(kCountText)
                         : kColorText + std::string(kSurfaceText) + kSampleText);
}

}  // namespace sluice
