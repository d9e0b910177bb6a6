// The warning of a run that drew pictures which show nothing: one line, however many there are.
#pragma once

#include <cstdint>
#include <string>

namespace sluice {

class EmptyPictures {
 public:
  // Called for each picture in turn; `why` is empty if it shows something.
  void add(const std::string& name, const std::string& why);
  // Prints the warning, if there is something to warn of.
  void warn() const;

 private:
  int64_t pictures_ = 0, empty_ = 0;
  std::string
      first_;  // "a.png shows nothing: the camera looks past the visible part of the volume"
};

}  // namespace sluice
