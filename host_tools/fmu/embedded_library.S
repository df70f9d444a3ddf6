/* The FMU's runtime as bytes of this program: exporting needs neither a compiler nor a file beside the program. */
    .section .rodata
    .global spindle_twin_fmu_library
    .global spindle_twin_fmu_library_end
    .balign 16
spindle_twin_fmu_library:
    .incbin SPINDLE_TWIN_FMU_FILE
spindle_twin_fmu_library_end:
    .byte 0
    .section .note.GNU-stack,"",%progbits
