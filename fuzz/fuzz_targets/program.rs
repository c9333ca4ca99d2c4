// The program of a target: one function tries an input, one changes it. A quarter of the changes are libFuzzer's own,
// which knows what the code has compared the input with.
macro_rules! program {
    ($target:ident) => {
        use lightmesh_fuzz::{Depth, Target, take_thread_pool};
        use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};

        fuzz_target!(init: take_thread_pool(), |data: &[u8]| {
            Target::$target.run(data, Depth::of(data));
        });

        fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
            if seed % 4 == 0 {
                return fuzzer_mutate(data, size, max_size);
            }
            let changed = Target::$target.mutate(&data[..size], u64::from(seed));
            let length = changed.len().min(max_size);
            data[..length].copy_from_slice(&changed[..length]);
            length
        });
    };
}
