// StrongIndex: a number that counts one kind of thing. A position among blocks is none among
// chunks, and a name is no position: a wrong one does not compile.
//
// IndexedVector: a vector that only its own kind of index opens. Plain values.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <ostream>
#include <vector>

namespace sluice {

template <class Tag>
class StrongIndex {
 public:
  constexpr StrongIndex() = default;
  constexpr explicit StrongIndex(int64_t value) : value_(value) {}
  constexpr explicit StrongIndex(size_t value) : value_(static_cast<int64_t>(value)) {}

  constexpr int64_t value() const { return value_; }
  constexpr StrongIndex& operator++() {
    ++value_;
    return *this;
  }
  friend constexpr auto operator<=>(const StrongIndex&, const StrongIndex&) = default;
  friend std::ostream& operator<<(std::ostream& out, StrongIndex index) {
    return out << index.value_;
  }

 private:
  int64_t value_ = 0;
};

template <class Index, class T>
class IndexedVector : public std::vector<T> {
 public:
  using std::vector<T>::vector;

  decltype(auto) operator[](Index index) {
    return std::vector<T>::operator[](static_cast<size_t>(index.value()));
  }
  decltype(auto) operator[](Index index) const {
    return std::vector<T>::operator[](static_cast<size_t>(index.value()));
  }
  // The index that the next element will get.
  Index endIndex() const { return Index(this->size()); }

  // A range for a loop over the indices of all elements.
  class Indices {
   public:
    struct Iterator {
      Index at;
      Index operator*() const { return at; }
      Iterator& operator++() {
        ++at;
        return *this;
      }
      friend bool operator==(const Iterator&, const Iterator&) = default;
    };
    explicit Indices(Index end) : end_(end) {}
    Iterator begin() const { return {Index()}; }
    Iterator end() const { return {end_}; }

   private:
    Index end_;
  };
  Indices indices() const { return Indices(endIndex()); }
};

}  // namespace sluice

template <class Tag>
struct std::hash<sluice::StrongIndex<Tag>> {
  size_t operator()(sluice::StrongIndex<Tag> index) const {
    return std::hash<int64_t>()(index.value());
  }
};
