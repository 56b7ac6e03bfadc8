// The few symbols a C++ binary without the C++ runtime library needs, so that it runs where none is installed.
#include <cstddef>
#include <cstdlib>

// Nothing is allocated with new: these serve the deleting destructors.
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t /*size*/) noexcept { std::free(memory); }

extern "C" {
[[noreturn]] void __cxa_pure_virtual() { std::abort(); }
}

#ifdef __MINGW64__
// Windows grows a stack page by page: a function whose frame is larger than a page calls this first, with the size in
// rax, to touch each page. It is all that binaries would need of the compiler's run-time library, which cannot be linked
// in part and is as large as they are. Registers stay as they are.
asm(R"(
    .globl ___chkstk_ms
___chkstk_ms:
    pushq %rax
    pushq %rcx
    leaq 24(%rsp), %rcx
    jmp 2f
1:  subq $4096, %rcx
    testb %cl, (%rcx)
    subq $4096, %rax
2:  cmpq $4096, %rax
    ja 1b
    subq %rax, %rcx
    testb %cl, (%rcx)
    popq %rcx
    popq %rax
    ret
)");
#endif
