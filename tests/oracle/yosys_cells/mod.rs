//! Every cell of Yosys, with random parameters and random four-valued inputs, against Icarus Verilog running Yosys' own
//! model of the cell. `models.v` holds models of those cells of which the installed library has none, or none that is
//! four-valued or right; it says why.

mod batch;
mod gates;
mod memory;
mod random;
mod storage;
mod word;

/// Every type that the importer takes is compared here.
#[test]
fn no_cell_is_left_out() {
    let mut compared: Vec<&str> = word::CELLS.iter().chain(storage::CELLS).chain(memory::CELLS).copied().collect();
    compared.extend(gates::COMBINATIONAL);
    assert_eq!(gates::COMBINATIONAL.len(), 20);
    assert_eq!(gates::storage_names().len(), 129);
    for name in
        "$not $pos $neg $reduce_and $reduce_or $reduce_xor $reduce_xnor $reduce_bool $logic_not $buf $barrier $slice \
                 $concat $lut $sop $and $or $xor $xnor $shl $shr $sshl $sshr $shift $shiftx $lt $le $eq $ne $eqx $nex \
                 $ge $gt $add $sub $mul $div $mod $divfloor $modfloor $pow $logic_and $logic_or $bweqx $macc $macc_v2 \
                 $mux $bwmux $pmux $bmux $demux $fa $lcu $alu $tribuf $sr $ff $dff $dffe $dffsr $dffsre $adff $adffe \
                 $aldff $aldffe $sdff $sdffe $sdffce $dlatch $adlatch $dlatchsr $mem $mem_v2 $memrd $memrd_v2 $memwr \
                 $memwr_v2 $meminit $meminit_v2"
            .split_whitespace()
    {
        assert!(compared.contains(&name), "nothing compares {name}");
    }
}
