/* The least start-up, for programs of which only the size matters. */

#include <stddef.h>
#include <stdint.h>

extern uint32_t stack_top;
int main(void);
void _start(void);

void _start(void)
{
    (void)main();
    for (;;) {
    }
}

__attribute__((section(".vectors"), used)) static void (*const vectors[])(void) = { NULL, _start };
