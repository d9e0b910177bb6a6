#include "tools/trace_files.h"

namespace sluice {

TraceFormat traceFormatOf(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension == ".txt") return TraceFormat::kText;
  if (extension == ".csv") return TraceFormat::kCsv;
  if (extension == ".din") return TraceFormat::kDin;
  if (extension == ".oracleGeneral") return TraceFormat::kOracleGeneral;
  return TraceFormat::kBinary;
}

}  // namespace sluice
