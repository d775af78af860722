/*
 * Preloaded into Debian's linux.uml (6.1) on processors with AMX.
 *
 * There it dies with "ptrace set fp regs failed, errno = 14": the buffer in which it keeps a process's floating-point
 * state is smaller than the host's state, of which the host takes only the whole. So what it writes is completed here.
 *
 *   cc -shared -fPIC -O2 -o amx_ptrace.so amx_ptrace.c
 */
#define _GNU_SOURCE
#include <elf.h>
#include <errno.h>
#include <stdarg.h>
#include <stdint.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

/* Where the header of the XSAVE area says which components are in use, and the two of them that are AMX's. */
enum { XSTATE_BV = 512 };
static const uint64_t AMX = UINT64_C(3) << 17;

/* Not on the stack, of which a kernel thread has a few pages only; linux.uml traces from one thread. */
static char whole[65536];

static long request_of(long request, pid_t pid, void *address, void *data)
{
    return syscall(SYS_ptrace, request, pid, address, data);
}

/* No program in User-mode Linux uses AMX: it has no system call by which a program could ask for it. */
static void without_amx(char *state)
{
    uint64_t used;

    memcpy(&used, state + XSTATE_BV, sizeof used);
    used &= ~AMX;
    memcpy(state + XSTATE_BV, &used, sizeof used);
}

static long set_floating_point(pid_t pid, void *type, struct iovec *given)
{
    struct iovec full = {whole, sizeof whole};

    if (request_of(PTRACE_GETREGSET, pid, type, &full) < 0)
        return -1;
    /* Also where more is given than there is, which is for the host to refuse. */
    if (given->iov_len >= full.iov_len || given->iov_len < XSTATE_BV + sizeof(uint64_t))
        return request_of(PTRACE_SETREGSET, pid, type, given);
    memcpy(whole, given->iov_base, given->iov_len);
    without_amx(whole);
    return request_of(PTRACE_SETREGSET, pid, type, &full);
}

/* The system call writes what it has read to an address; the library's function returns it. */
static long peek(long request, pid_t pid, void *address)
{
    long value;

    if (request_of(request, pid, address, &value) < 0)
        return -1;
    errno = 0;
    return value;
}

long ptrace(enum __ptrace_request request, ...)
{
    va_list arguments;
    va_start(arguments, request);
    pid_t pid = va_arg(arguments, pid_t);
    void *address = va_arg(arguments, void *);
    void *data = va_arg(arguments, void *);
    va_end(arguments);

    switch (request) {
    case PTRACE_SETREGSET:
        if ((uintptr_t)address == NT_X86_XSTATE)
            return set_floating_point(pid, address, data);
        break;
    case PTRACE_PEEKTEXT:
    case PTRACE_PEEKDATA:
    case PTRACE_PEEKUSER:
        return peek(request, pid, address);
    default:
        break;
    }
    return request_of(request, pid, address, data);
}
