#include "tools/manual/manual_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <sstream>

namespace sluice {
namespace {

// `text` as roff shows it letter by letter, so that what is copied from the page is what was meant.
std::string escaped(const std::string& text) {
  std::string result;
  // Left alone, groff prints typographic quotes, hyphens and accents, which shells do not take.
  for (const char c : text) switch (c) {
      case '\\':
        result += "\\e";
        break;
      case '-':
        result += "\\-";
        break;
      case '\'':
        result += "\\(aq";
        break;
      case '`':
        result += "\\(ga";
        break;
      case '^':
        result += "\\(ha";
        break;
      case '~':
        result += "\\(ti";
        break;
      default:
        result += c;
    }
  return result;
}

// The same for a whole line, of which the first character must not be a command.
std::string line(const std::string& text) {
  return (text.starts_with('.') ? "\\&" : "") + escaped(text) + "\n";
}

std::string bold(const std::string& text) {
  return "\\fB" + escaped(text) + "\\fR";
}
std::string italic(const std::string& text) {
  return "\\fI" + escaped(text) + "\\fR";
}

std::string upper(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

std::string dashed(std::string name) {
  std::ranges::replace(name, ' ', '-');
  return name;
}

std::string reference(const std::string& name) {
  return bold(dashed(name)) + "(1)";
}

// Paragraphs, with blank lines between. Indented lines are examples and lists, which stay as they
// are.
std::string paragraphs(const std::string& text) {
  std::istringstream lines(text);
  std::string result;
  bool is_fixed = false, is_first = true;
  for (std::string each; std::getline(lines, each);) {
    const bool fixed = each.starts_with(' ');
    if (fixed != is_fixed) {
      result += fixed ? ".PP\n.nf\n.RS\n" : ".RE\n.fi\n";
      is_first = !fixed;
    }
    is_fixed = fixed;
    if (each.empty()) {
      is_first = true;
      continue;
    }
    if (is_first && !fixed) result += ".PP\n";
    is_first = false;
    result += line(fixed ? each.substr(2) : each);
  }
  return result + (is_fixed ? ".RE\n.fi\n" : "");
}

std::string placeholder(const OptionText& argument) {
  return italic(argument.value) + (argument.is_list ? "..." : "");
}

std::string optionEntry(const OptionText& option) {
  std::string text = ".TP\n";
  std::string names;
  for (const std::string& name : option.names) names += (names.empty() ? "" : ", ") + bold(name);
  if (option.names.empty()) {
    text += italic(option.value);
  } else {
    text += names + (option.value.empty() ? "" : " " + italic(option.value));
  }
  std::string help = option.help;
  if (!option.default_value.empty()) help += " [" + option.default_value + "]";
  if (option.is_required && !option.names.empty()) help += " (required)";
  return text + "\n" + line(help);
}

std::string synopsis(const CommandText& command) {
  std::string text = ".SH SYNOPSIS\n" + bold(command.name);
  if (!command.commands.empty()) text += " " + italic("COMMAND");
  for (const OptionText& argument : command.arguments) text += " " + placeholder(argument);
  return text + " [" + italic("OPTION") + "...]\n";
}

std::string commandList(const CommandText& command) {
  std::string text = command.commands.empty() ? "" : ".SH COMMANDS\n";
  std::string heading;
  for (const CommandText& each : command.commands) {
    if (each.heading != heading && command.name.find(' ') == std::string::npos)
      text += ".SS " + escaped(each.heading) + "\n";
    heading = each.heading;
    text += ".TP\n" + reference(each.name) + "\n" + line(each.summary);
  }
  return text;
}

std::string optionList(const CommandText& command) {
  std::string text = ".SH OPTIONS\n";
  for (const OptionText& argument : command.arguments) text += optionEntry(argument);
  for (const OptionHeading& heading : command.headings) {
    text += ".SS " + escaped(heading.title) + "\n";
    for (const OptionText& option : heading.options) text += optionEntry(option);
  }
  return text;
}

constexpr const char* kExitStatus =
    ".SH EXIT STATUS\n"
    ".TP\n.B 0\nSuccess, and all output was written.\n"
    ".TP\n.B 1\nBad input or a bad environment. One line on standard error names the file or "
    "option, "
    "the expected and the found value.\n"
    ".TP\n.B 2\nWrong usage.\n"
    ".TP\n.BR 129 \", \" 130 \", \" 143\n"
    "Ended by SIGHUP, SIGINT or SIGTERM, after its temporary files were removed.\n";

// The other commands of its list, and the one above.
std::string seeAlso(const CommandText& command, const CommandText& program) {
  std::string text;
  for (const CommandText* above : withCommandsBelow(program)) {
    const bool is_above = std::ranges::any_of(
        above->commands, [&](const CommandText& each) { return each.name == command.name; });
    if (!is_above) continue;
    text += reference(above->name);
    for (const CommandText& each : above->commands)
      if (each.name != command.name) text += ",\n" + reference(each.name);
  }
  return text.empty() ? "" : ".SH SEE ALSO\n" + text + "\n";
}

}  // namespace

std::string manualPageName(const CommandText& command) {
  return dashed(command.name) + ".1";
}

std::string manualPage(const CommandText& command, const CommandText& program) {
  const bool is_program = command.name == program.name;
  std::string summary =
      is_program ? program.summary.substr(program.summary.find(": ") + 2) : command.summary;
  summary.front() = static_cast<char>(std::tolower(static_cast<unsigned char>(summary.front())));
  return fmt::format(".TH {} 1 {} \"sluice {}\" \"Manual of sluice\"\n",
                     escaped(upper(dashed(command.name))), SLUICE_RELEASE_DATE, SLUICE_VERSION) +
         ".SH NAME\n" + escaped(dashed(command.name)) + " \\- " + escaped(summary) + "\n" +
         synopsis(command) + ".SH DESCRIPTION\n" + line(command.summary + ".") +
         paragraphs(command.description) + commandList(command) + optionList(command) +
         kExitStatus + seeAlso(command, program);
}

}  // namespace sluice
