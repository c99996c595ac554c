#include "arbox/io/internal/pickle_machine.h"
#include "arbox/io/internal/pickle_text.h"

// Instructions by their bytes, as Python's pickletools lists them.

namespace arbox::io::internal {

PickleMachine::Number PickleMachine::run() {
  for (;;) {
    instruction_ = at_;
    const char code = take(1).front();
    if (code == '.') return pop();
    if (!step(code) && !step_numbers(code) && !step_characters(code) && !step_object(code) &&
        !step_old(code)) {
      refuse("expected an instruction of pickle protocols 0 to 5, got byte " +
             std::to_string(static_cast<unsigned char>(code)));
    }
  }
}

bool PickleMachine::step(char code) {
  switch (code) {
    case '(':
      marks_.push_back(stack_.size());
      break;
    case ']':
      push_sequence(PickleKind::kList, {});
      break;
    case '}':
      push_sequence(PickleKind::kDict, {});
      break;
    case '\x8f':
      push_sequence(PickleKind::kSet, {});
      break;
    case '\x91':
      push_sequence(PickleKind::kSet, pop_to_mark());
      break;
    case ')':
      push_sequence(PickleKind::kTuple, {});
      break;
    case 't':
      push_sequence(PickleKind::kTuple, pop_to_mark());
      break;
    case '\x85':
    case '\x86':
    case '\x87':
      push_sequence(PickleKind::kTuple, pop_last(static_cast<unsigned char>(code) - 0x84U));
      break;
    case 'a':
      append_values(pop_last(1));
      break;
    case 'e':
    case '\x90':
      append_values(pop_to_mark());
      break;
    case 's':
      set_values(pop_last(2));
      break;
    case 'u':
      set_values(pop_to_mark());
      break;
    case 'q':
      memo_.put(unsigned_number(1), top());
      break;
    case 'r':
      memo_.put(unsigned_number(4), top());
      break;
    case '\x94':
      memo_.put(memo_.size(), top());
      break;
    case 'h':
      get(unsigned_number(1));
      break;
    case 'j':
      get(unsigned_number(4));
      break;
    case '2':
      push(top());
      break;
    case '0':
      pop();
      break;
    case '1':
      pop_to_mark();
      break;
    case '\x80':
      protocol(unsigned_number(1));
      break;
    case '\x95':
      frame(unsigned_number(8));
      break;
    default:
      return false;
  }
  return true;
}

bool PickleMachine::step_numbers(char code) {
  switch (code) {
    case 'N':
      push(kNone);
      break;
    case '\x88':
      push(kTrue);
      break;
    case '\x89':
      push(kFalse);
      break;
    case 'J':
      push_integer(static_cast<std::int32_t>(unsigned_number(4)));
      break;
    case 'K':
      push_integer(static_cast<std::int64_t>(unsigned_number(1)));
      break;
    case 'M':
      push_integer(static_cast<std::int64_t>(unsigned_number(2)));
      break;
    case '\x8a':
      push_long(take(unsigned_number(1)));
      break;
    case '\x8b':
      push_long(take(unsigned_number(4)));
      break;
    case 'G':
      push_float(big_endian_double());
      break;
    default:
      return false;
  }
  return true;
}

bool PickleMachine::step_characters(char code) {
  switch (code) {
    case 'X':
      push_characters(PickleKind::kText, take(unsigned_number(4)));
      break;
    case '\x8c':
      push_characters(PickleKind::kText, take(unsigned_number(1)));
      break;
    case '\x8d':
      push_characters(PickleKind::kText, take(unsigned_number(8)));
      break;
    case 'T':
    case 'B':
      push_characters(PickleKind::kBytes, take(unsigned_number(4)));
      break;
    case 'U':
    case 'C':
      push_characters(PickleKind::kBytes, take(unsigned_number(1)));
      break;
    case '\x8e':
    case '\x96':
      push_characters(PickleKind::kBytes, take(unsigned_number(8)));
      break;
    default:
      return false;
  }
  return true;
}

bool PickleMachine::step_object(char code) {
  switch (code) {
    case 'c': {
      const std::string_view module = take_line();
      push_named_global(module, take_line());
      break;
    }
    case '\x93': {
      const auto names = pop_last(2);
      push_global(names[0], names[1]);
      break;
    }
    case 'R':
    case '\x81': {
      const auto call = pop_last(2);
      reduce(call[0], call[1]);
      break;
    }
    case '\x92': {
      const auto call = pop_last(3);
      reduce(call[0], call[1]);
      if (node(call[2]).kind != PickleKind::kDict) refuse("expected a dictionary of arguments");
      tree_.object(node(top())).named_arguments = call[2];
      break;
    }
    case 'b':
      build();
      break;
    case 'o': {
      auto values = pop_to_mark();
      if (values.empty()) refuse("expected a class after the mark, got nothing");
      const Number callable = values.front();
      values.erase(values.begin());
      push_object(callable, new_tuple(std::move(values)));
      break;
    }
    case 'i': {
      auto values = pop_to_mark();
      const std::string_view module = take_line();
      push_named_global(module, take_line());
      const Number callable = pop();
      push_object(callable, new_tuple(std::move(values)));
      break;
    }
    case 'P':
      push_sequence(PickleKind::kPersistent, {new_text(take_line())});
      break;
    case 'Q':
      push_sequence(PickleKind::kPersistent, {pop()});
      break;
    case '\x82':
    case '\x83':
    case '\x84':
      refuse("values of Python's registry of extensions are not in the file");
    case '\x97':
    case '\x98':
      refuse("buffers outside of the pickle are not in the file");
    default:
      return false;
  }
  return true;
}

bool PickleMachine::step_old(char code) {
  switch (code) {
    case 'I': {
      const std::string_view line = take_line();
      if (line == "00" || line == "01") {
        push(line == "01" ? kTrue : kFalse);
      } else {
        push_integer(number_of<std::int64_t>(line));
      }
      break;
    }
    case 'L': {
      std::string_view line = take_line();
      if (line.ends_with('L')) line.remove_suffix(1);
      push_integer(number_of<std::int64_t>(line));
      break;
    }
    case 'F':
      push_float(number_of<double>(take_line()));
      break;
    case 'S': {
      const std::string_view line = take_line();
      push_decoded(PickleKind::kBytes, unquoted_python_string(line), line);
      break;
    }
    case 'V': {
      const std::string_view line = take_line();
      push_decoded(PickleKind::kText, decode_raw_unicode_escape(line), line);
      break;
    }
    case 'l':
      push_sequence(PickleKind::kList, pop_to_mark());
      break;
    case 'd': {
      const auto values = pop_to_mark();
      push_sequence(PickleKind::kDict, {});
      set_items(top(), values);
      break;
    }
    case 'p':
      memo_.put(number_of<std::uint64_t>(take_line()), top());
      break;
    case 'g':
      get(number_of<std::uint64_t>(take_line()));
      break;
    default:
      return false;
  }
  return true;
}

}  // namespace arbox::io::internal
