// Replays physical_deception.vectors.txt: rustc --edition 2021 physical_deception_test.rs && ./physical_deception_test
mod physical_deception;
fn main() {
    let (mut n, mut wrong) = (0, 0);
    for line in std::fs::read_to_string("physical_deception.vectors.txt").unwrap().lines().filter(|line| !line.starts_with('#')) {
        let parts: Vec<&str> = line.split(' ').collect();
        let x: Vec<f32> = parts[2..].iter().map(|bits| f32::from_bits(u32::from_str_radix(bits, 16).unwrap())).collect();
        let action = match parts[0] {
            "0" => physical_deception::adversary_0::act(x.as_slice().try_into().unwrap()),
            "1" => physical_deception::agent_0::act(x.as_slice().try_into().unwrap()),
            "2" => physical_deception::agent_1::act(x.as_slice().try_into().unwrap()),
            _ => unreachable!(),
        };
        n += 1;
        wrong += (action.to_string() != parts[1]) as usize;
    }
    println!("{} vectors, {} wrong", n, wrong);
    std::process::exit((wrong != 0 || n == 0) as i32);
}
