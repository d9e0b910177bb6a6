// GlProgram: a linked pair of shaders and the places of its uniforms. One thread, the context's.
#pragma once

#include <string>
#include <unordered_map>

#include "src/base/values/vec.h"
#include "src/gl/contexts/gl_functions.h"

namespace sluice {

class GlProgram {
 public:
  // Throws Error with the driver's log: some drivers refuse code that others take. `gl` must
  // outlive it.
  GlProgram(const GlFunctions& gl, const std::string& vertex, const std::string& fragment);
  ~GlProgram();
  GlProgram(const GlProgram&) = delete;
  GlProgram& operator=(const GlProgram&) = delete;

  void use() const { gl_.UseProgram(program_); }
  // From now on set() means the uniforms of this channel (BlendedVariant), or those that all share.
  void ofChannel(size_t channel);
  void ofAll() { suffix_.clear(); }
  // Uniforms that the compiler dropped are ignored. Requires: the program is in use.
  void set(const char* name, int value);
  void set(const char* name, double value);
  void set(const char* name, Vec3d value);
  void set2(const char* name, const float* values);
  void set2(const char* name, double x, double y);
  void set4(const char* name, const float* values, int count);
  void set1(const char* name, const float* values, int count);
  void set3(const char* name, const float* values, int count);

 private:
  GLint locate(const char* name);

  const GlFunctions& gl_;
  GLuint program_ = 0;
  std::string suffix_;
  std::unordered_map<std::string, GLint> locations_;
};

}  // namespace sluice
