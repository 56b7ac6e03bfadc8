// The few symbols a C++ binary without the C++ runtime library needs, so that it runs where none is installed.
#include <cstddef>
#include <cstdlib>

// Nothing is allocated with new: these serve the deleting destructors.
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t /*size*/) noexcept { std::free(memory); }

extern "C" {
[[noreturn]] void __cxa_pure_virtual() { std::abort(); }
}
