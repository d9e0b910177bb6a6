// The module sluice._sluice. The package's Python (python/sluice/__init__.py) wraps it: what people
// see, with its documentation, is there.
#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <sluice/sluice.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "python/arrays.h"
#include "python/keyword_rules.h"
#include "python/keywords.h"
#include "python/picture_options.h"
#include "python/renderer_handle.h"
#include "python/running.h"
#include "python/simulation.h"
#include "src/base/field_names.h"

namespace sluice::python {
namespace {

VolumeOptions::Levels levelsOf(const py::handle& value) {
  using Levels = VolumeOptions::Levels;
  if (value.is_none()) return Levels::kKept;
  const auto word = py::str(value).cast<std::string>();
  for (const auto& [name, levels] : {std::pair("auto", Levels::kAuto),
                                     {"always", Levels::kAlways},
                                     {"kept", Levels::kKept},
                                     {"none", Levels::kNone}})
    if (word == name) return levels;
  throw py::value_error("levels: expected 'auto', 'always', 'kept' or 'none', found " +
                        py::repr(value).cast<std::string>());
}

// The keywords of volumeOptions() for the key of buckets; `variable` is os.environ.get.
py::dict bucketAccess(const py::function& variable) {
  const VolumeOptions::Web web = Volume::bucketAccess([&](const std::string& name) {
    const py::object value = variable(name);
    return value.is_none() ? std::string() : value.cast<std::string>();
  });
  py::dict keywords;
  keywords["access_key"] = web.access_key;
  keywords["secret_key"] = web.secret_key;
  keywords["session_token"] = web.session_token;
  keywords["region"] = web.region;
  keywords["endpoint"] = web.endpoint;
  return keywords;
}

VolumeOptions volumeOptions(const py::dict& keywords) {
  VolumeOptions options;
  const auto take = [&](const char* keyword, auto& held) { takeKeyword(keywords, keyword, held); };
  takeVolumeKeywords(keywords, options);
  take("whole_series", options.whole_series);
  take("opens_soon", options.opens_soon);
  take("time", options.time);
  take("index_dir", options.index_folder);
  take("temporary_dir", options.temporary_folder);
  take("cache_dir", options.web.cache_folder);
  take("cache", options.web.cache_bytes);
  take("certificate_file", options.web.certificate_file);
  take("certificate_folder", options.web.certificate_folder);
  take("access_key", options.web.access_key);
  take("secret_key", options.web.secret_key);
  take("session_token", options.web.session_token);
  take("region", options.web.region);
  take("endpoint", options.web.endpoint);
  take("block", options.block);
  take("page", options.page);
  take("memory", options.memory_bytes);
  take("threads", options.threads);
  if (keywords.contains("levels")) options.levels = levelsOf(keywords["levels"]);
  return options;
}

std::unique_ptr<VolumeHandle> openFiles(const std::vector<std::string>& paths,
                                        const py::dict& keywords, const py::object& progress) {
  const VolumeOptions options = volumeOptions(keywords);
  const ProgressFunction told = progressFunction(progress);
  return std::make_unique<VolumeHandle>(
      VolumeHandle{py::none(), Held<Volume>(run([&](const std::stop_token& stop) {
                     return Volume(paths, options, told, stop);
                   }))});
}

std::unique_ptr<VolumeHandle> openArray(const py::array& array, const ArrayPlace& place,
                                        const py::dict& keywords, const py::object& progress) {
  return std::make_unique<VolumeHandle>(VolumeHandle{
      array,
      Held<Volume>(borrowed(array, place, volumeOptions(keywords), progressFunction(progress)))});
}

std::unique_ptr<VolumeHandle> openFunction(const py::function& fill,
                                           const std::vector<int64_t>& shape, const py::dtype& type,
                                           const ArrayPlace& place, const py::dict& keywords,
                                           const py::object& progress) {
  return std::make_unique<VolumeHandle>(VolumeHandle{
      py::none(), Held<Volume>(filled(fill, shape, type, place, volumeOptions(keywords),
                                      progressFunction(progress)))});
}

py::dict infoOf(const VolumeHandle& handle) {
  const VolumeInfo& info = handle.volume.get().info();
  py::dict out;
  out["name"] = info.name;
  out["dims"] = py::tuple(py::cast(info.dims));
  out["type"] = info.type;
  out["spacing"] = py::tuple(py::cast(info.spacing));
  out["origin"] = py::tuple(py::cast(info.origin));
  out["unit"] = info.unit;
  out["axes"] = info.axes;
  out["frame"] = info.frame;
  out["time_steps"] = info.time_steps;
  out["levels"] = info.levels;
  out["value_range"] = py::tuple(py::cast(info.value_range));
  out["warnings"] = info.warnings;
  out["files"] = info.files;
  return out;
}

py::tuple histogramOf(const VolumeHandle& handle, int bins) {
  const Volume& volume = handle.volume.get();
  ValueHistogram histogram = run([&](const std::stop_token&) { return volume.histogram(bins); });
  std::vector<double> edges(histogram.counts.size() + 1);
  const double width = (histogram.hi - histogram.lo) / static_cast<double>(histogram.counts.size());
  for (size_t i = 0; i < edges.size(); ++i)
    edges[i] = histogram.lo + width * static_cast<double>(i);
  edges.back() = histogram.hi;
  const auto count = static_cast<py::ssize_t>(histogram.counts.size());
  return py::make_tuple(arrayOf(std::move(histogram.counts), {count}),
                        arrayOf(std::move(edges), {count + 1}));
}

// A message of the library with keywords for the options that it names.
std::string messageOf(const Error& error) {
  std::string line = inKeywords(lineInOptions(error));
  // These fields are keywords of Renderer().
  constexpr std::string_view kPipeline = "pipeline.";
  return line.starts_with(kPipeline) ? line.substr(kPipeline.size()) : line;
}

const char* nameOf(Error::Kind kind) {
  switch (kind) {
    case Error::Kind::kInput:
      return "input";
    case Error::Kind::kRequest:
      return "request";
    case Error::Kind::kMemory:
      return "memory";
    case Error::Kind::kSystem:
      return "system";
  }
  return "system";
}

// Exceptions of the library. `Cancelled` reaches Python if a call was stopped by another's Ctrl-C.
void addErrors(py::module_& module) {
  static const py::object type = py::exception<Error>(module, "Error", PyExc_RuntimeError);
  type.attr("__module__") = "sluice";
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      std::rethrow_exception(std::move(thrown));
    } catch (const Error& error) {
      const py::object raised = type(messageOf(error));
      raised.attr("kind") = nameOf(error.kind());
      PyErr_SetObject(type.ptr(), raised.ptr());
    }
  });
  py::register_exception<Cancelled>(module, "Cancelled", PyExc_RuntimeError);
}

}  // namespace

PYBIND11_MODULE(_sluice, module) {
  addErrors(module);
  module.attr("__version__") = SLUICE_VERSION;
  module.def("bucket_access", &bucketAccess, py::arg("variable"));
  py::class_<ArrayPlace>(module, "ArrayPlace")
      .def(py::init(
               [](const Triple& spacing, const Triple& origin, std::string unit, std::string name) {
                 return ArrayPlace{spacing, origin, std::move(unit), std::move(name)};
               }),
           py::arg("spacing"), py::arg("origin"), py::arg("unit"), py::arg("name"));
  py::class_<VolumeHandle>(module, "Volume")
      .def("info", &infoOf)
      .def("histogram", &histogramOf, py::arg("bins"));
  py::class_<RendererHandle>(module, "Renderer")
      .def(py::init([](const VolumeHandle& volume, const std::string& device, uint64_t memory,
                       int threads, const py::dict& pipeline) {
             return std::make_unique<RendererHandle>(volume, device, memory, threads, pipeline);
           }),
           py::arg("volume"), py::arg("device"), py::arg("memory"), py::arg("threads"),
           py::arg("pipeline"), py::keep_alive<1, 2>())
      .def("render", &RendererHandle::render)
      .def("save", &RendererHandle::save)
      .def("plan", &RendererHandle::plan)
      .def("probe", &RendererHandle::probe)
      .def("slice", &RendererHandle::slice)
      .def("look", &RendererHandle::look)
      .def("device", &RendererHandle::device)
      .def("record_to", &RendererHandle::recordTo)
      .def("report", &RendererHandle::report);
  module.def("open_files", &openFiles);
  module.def("open_array", &openArray);
  module.def("open_function", &openFunction);
  module.def("keywords", &pictureKeywords);
  module.def("keyword_types", &pictureKeywordTypes);
  module.def("volume_keyword_types", &volumeKeywordTypes);
  module.def("simulate", [](SimulationRequest request) {
    return run([&](const std::stop_token&) { return simulatedRows(request); });
  });
  py::class_<SimulationRequest>(module, "SimulationRequest")
      .def(py::init<>())
      .def_readwrite("trace", &SimulationRequest::trace)
      .def_readwrite("policies", &SimulationRequest::policies)
      .def_readwrite("sizes", &SimulationRequest::sizes)
      .def_readwrite("format", &SimulationRequest::format)
      .def_readwrite("page_bytes", &SimulationRequest::page_bytes)
      .def_readwrite("pins", &SimulationRequest::pins);
}

}  // namespace sluice::python
