// Finds the word that somebody probably meant. Pure functions.
#pragma once

#include <string>
#include <vector>

namespace sluice {

// Letters to insert, delete, replace or swap with the next to make one word of the other, without
// regard to case.
size_t editDistance(const std::string& a, const std::string& b);

// The known word that is closest to `word`, when it is close (a third of its letters, at least 1),
// or begins with it, or is part of it; empty otherwise. Dashes in front do not count.
std::string nearest(const std::string& word, const std::vector<std::string>& known);

}  // namespace sluice
